# SPDX-License-Identifier: GPL-3.0-or-later
# bench_ground: simulated ground and its oriented points, for every bench that reconstructs.
cornice_library(bench_ground surface/accuracy.cpp surface/ground.cpp)
target_link_libraries(
  cornice_bench_ground
  PUBLIC cornice_simulate_scene cornice_mesh cornice_poisson_extract
  PRIVATE cornice_bench cornice_simulate_survey cornice_normals cornice_las cornice_io)

cornice_add_bench(surface cornice_bench_ground cornice_poisson_engine cornice_poisson_extract
                  cornice_io)
target_compile_definitions(bench-surface
                           PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes")
add_dependencies(bench-surface cornice-flightlines)
