# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(simulate_survey_truth property/simulate_survey/geometry_test.cpp
             property/simulate_survey/defects_test.cpp property/simulate_survey/files_test.cpp
             property/simulate_survey/flown.cpp property/simulate_survey/test_scenes.cpp
             LIBS cornice_simulate_survey cornice_test_support)
target_include_directories(test-simulate_survey_truth PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
