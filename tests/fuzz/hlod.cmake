# SPDX-License-Identifier: GPL-3.0-or-later
# fuzz-hlod: libFuzzer on .hlod files. The reader is compiled in, so that it is instrumented.
if(CORNICE_BUILD_FUZZ)
  set(hlod "${PROJECT_SOURCE_DIR}/hlod")
  add_executable(
    fuzz-hlod fuzz/hlod_fuzz.cpp ${hlod}/codec.cpp ${hlod}/codec_bytes.cpp ${hlod}/codec_fields.cpp
              ${hlod}/codec_predict.cpp ${hlod}/codec_walk.cpp ${hlod}/file.cpp ${hlod}/file_head.cpp
              ${hlod}/file_nodes.cpp ${hlod}/morph.cpp ${hlod}/select.cpp
              ${hlod}/select_tree.cpp)
  cornice_configure(fuzz-hlod)
  target_compile_options(fuzz-hlod PRIVATE -g -fsanitize=fuzzer,address,undefined
                                           -fno-sanitize-recover=all -UNDEBUG)
  target_link_options(fuzz-hlod PRIVATE -fsanitize=fuzzer,address,undefined)
  target_link_libraries(fuzz-hlod PRIVATE cornice_base xxhash::xxhash zstd::zstd)
  add_test(NAME fuzz.hlod COMMAND fuzz-hlod -max_total_time=15 -max_len=4096 -rss_limit_mb=1024)
endif()
