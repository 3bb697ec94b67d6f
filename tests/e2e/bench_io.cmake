# SPDX-License-Identifier: GPL-3.0-or-later
# That the benchmark runs and writes its figures; what they are is not judged here.
if(CORNICE_BUILD_BENCH)
  add_test(NAME bench.io COMMAND "${CMAKE_BINARY_DIR}/bin/bench-io" --quick --json
                                 "${CMAKE_CURRENT_BINARY_DIR}/bench-io.json")
endif()
