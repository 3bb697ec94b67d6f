# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(simulate_survey_run e2e/simulate_survey/run_test.cpp
             LIBS cornice_las cornice_io cornice_test_support nlohmann_json::nlohmann_json)
target_include_directories(test-simulate_survey_run PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
add_dependencies(test-simulate_survey_run cornice-simulate)
if(CORNICE_BUILD_BENCH)
  add_test(NAME bench.simulate
           COMMAND "${CMAKE_BINARY_DIR}/bin/bench-simulate" --quick --scene cliff --json
                   "${CMAKE_CURRENT_BINARY_DIR}/bench-simulate.json")
endif()
