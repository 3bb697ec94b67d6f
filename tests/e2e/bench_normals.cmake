# SPDX-License-Identifier: GPL-3.0-or-later
# That the benchmarks run and write their figures; what they are is not judged here.
if(CORNICE_BUILD_BENCH)
  add_test(NAME bench.normals
           COMMAND "${CMAKE_BINARY_DIR}/bin/bench-normals" --quick --points 100000 --json
                   "${CMAKE_CURRENT_BINARY_DIR}/bench-normals.json")
  add_test(NAME bench.orientation
           COMMAND "${CMAKE_BINARY_DIR}/bin/bench-orientation" --quick --tile-m 60 --scanners palmer
                   --json "${CMAKE_CURRENT_BINARY_DIR}/bench-orientation.json")
endif()
