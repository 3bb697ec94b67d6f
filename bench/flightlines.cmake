# SPDX-License-Identifier: GPL-3.0-or-later
# The score is a library of its own because the property tests use it too.
cornice_library(flightlines_score flightlines/survey_score.cpp)
target_link_libraries(cornice_flightlines_score PUBLIC cornice_flightlines cornice_simulate_survey
                                                       cornice_simulate_scene)
cornice_add_bench(flightlines cornice_flightlines_score)
target_compile_definitions(bench-flightlines
                           PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes")
