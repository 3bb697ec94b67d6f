# SPDX-License-Identifier: GPL-3.0-or-later
# fuzz-ply: libFuzzer on the PLY reader. The reader is compiled in, so that it is instrumented.
if(CORNICE_BUILD_FUZZ)
  add_executable(
    fuzz-ply fuzz/ply_fuzz.cpp "${PROJECT_SOURCE_DIR}/core/io/ply_header.cpp"
             "${PROJECT_SOURCE_DIR}/core/io/ply_reader.cpp"
             "${PROJECT_SOURCE_DIR}/core/io/ply_records.cpp"
             "${PROJECT_SOURCE_DIR}/core/io/ply_stream.cpp")
  cornice_configure(fuzz-ply)
  target_compile_options(fuzz-ply PRIVATE -g -fsanitize=fuzzer,address,undefined
                                          -fno-sanitize-recover=all -UNDEBUG)
  target_link_options(fuzz-ply PRIVATE -fsanitize=fuzzer,address,undefined)
  target_link_libraries(fuzz-ply PRIVATE cornice_base)
  add_test(NAME fuzz.ply COMMAND fuzz-ply -max_total_time=15 -max_len=4096 -rss_limit_mb=1024
                                 -dict=${CMAKE_CURRENT_SOURCE_DIR}/fuzz/ply.dict)
endif()
