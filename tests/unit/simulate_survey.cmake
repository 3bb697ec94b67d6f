# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(simulate_survey unit/simulate_survey/scanner_test.cpp
             unit/simulate_survey/trajectory_test.cpp unit/simulate_survey/returns_test.cpp
             unit/simulate_survey/products_test.cpp unit/simulate_survey/defects_test.cpp
             unit/simulate_survey/truth_test.cpp property/simulate_survey/test_scenes.cpp
             LIBS cornice_simulate_survey cornice_test_support)
target_include_directories(test-simulate_survey PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
