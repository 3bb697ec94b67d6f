# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_dem e2e/dem/dem_test.cpp
             LIBS cornice_io cornice_mesh cornice_test_support nlohmann_json::nlohmann_json GDAL::GDAL)
add_dependencies(test-e2e_dem cornice-dem cornice-stitch)
if(CORNICE_BUILD_BENCH)
  add_test(NAME bench.dem
           COMMAND "${CMAKE_BINARY_DIR}/bin/bench-dem" --quick --json
                   "${CMAKE_CURRENT_BINARY_DIR}/bench-dem.json")
endif()
