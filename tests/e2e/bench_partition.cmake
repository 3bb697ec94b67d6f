# SPDX-License-Identifier: GPL-3.0-or-later
# That the benchmark runs and writes its figures; what they are is not judged here.
if(CORNICE_BUILD_BENCH)
  add_test(NAME bench.partition COMMAND "${CMAKE_BINARY_DIR}/bin/bench-partition" --quick --json
                                        "${CMAKE_CURRENT_BINARY_DIR}/bench-partition.json")
endif()
