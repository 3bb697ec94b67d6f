# SPDX-License-Identifier: GPL-3.0-or-later
# bench_truth: a piece of a scene as a DEM and as the surface that a DEM cannot hold.
cornice_library(bench_truth compare/truth.cpp)
target_link_libraries(cornice_bench_truth PUBLIC cornice_simulate_scene cornice_compare cornice_mesh
                                          PRIVATE cornice_simulate_survey cornice_io)
target_compile_definitions(cornice_bench_truth
                           PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes")

cornice_add_bench(compare cornice_bench_truth)
