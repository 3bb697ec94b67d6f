# SPDX-License-Identifier: GPL-3.0-or-later
# That the benchmarks run and write their figures; what they are is not judged here.
if(CORNICE_BUILD_BENCH)
  foreach(bench seams surface)
    add_test(NAME bench.${bench} COMMAND "${CMAKE_BINARY_DIR}/bin/bench-${bench}" --quick --json
                                         "${CMAKE_CURRENT_BINARY_DIR}/bench-${bench}.json")
  endforeach()
endif()
