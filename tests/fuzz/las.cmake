# SPDX-License-Identifier: GPL-3.0-or-later
# test-las_mutations: the parsers under changed bytes, with any compiler. fuzz-las: the same under
# libFuzzer, `fuzz-las-corpus corpus && fuzz-las -max_total_time=60 corpus`.
cornice_test(las_mutations fuzz/las_mutation_test.cpp fuzz/las_entry.cpp fuzz/las_seeds.cpp
             support/small_files.cpp property/las_writer/clouds.cpp
             LIBS cornice_las cornice_test_support GDAL::GDAL)

if(CORNICE_BUILD_FUZZ)
  add_executable(fuzz-las-corpus fuzz/las_corpus.cpp fuzz/las_seeds.cpp support/small_files.cpp
                                 property/las_writer/clouds.cpp)
  cornice_configure(fuzz-las-corpus)
  target_link_libraries(fuzz-las-corpus PRIVATE cornice_las cornice_test_support GDAL::GDAL)

  # The parsers are compiled again, so that the fuzzer sees which of their branches are taken.
  set(parsers byte_source zip_source las_header las_vlr laz_vlr laz_chunk_table las_chunks
              copc_hierarchy lax_reader)
  list(TRANSFORM parsers PREPEND "${PROJECT_SOURCE_DIR}/core/io/")
  list(TRANSFORM parsers APPEND ".cpp")
  add_executable(fuzz-las fuzz/las_fuzz.cpp fuzz/las_entry.cpp ${parsers})
  cornice_configure(fuzz-las)
  target_compile_options(fuzz-las PRIVATE -g -fsanitize=fuzzer,address,undefined
                                          -fno-sanitize-recover=all -UNDEBUG)
  target_link_options(fuzz-las PRIVATE -fsanitize=fuzzer,address,undefined)
  target_link_libraries(fuzz-las PRIVATE cornice_base GDAL::GDAL)
  add_test(NAME fuzz.las_corpus COMMAND fuzz-las-corpus "${CMAKE_CURRENT_BINARY_DIR}/las-corpus")
  set_tests_properties(fuzz.las_corpus PROPERTIES FIXTURES_SETUP las-corpus)
  add_test(NAME fuzz.las COMMAND fuzz-las -max_total_time=15 -max_len=16384 -rss_limit_mb=1024
                                 "${CMAKE_CURRENT_BINARY_DIR}/las-corpus")
  set_tests_properties(fuzz.las PROPERTIES FIXTURES_REQUIRED las-corpus)
endif()
