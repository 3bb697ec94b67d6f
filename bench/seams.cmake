# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(seams cornice_bench_ground cornice_poisson_engine cornice_poisson_extract
                  cornice_mesh cornice_io)
target_sources(bench-seams PRIVATE seams/tiled.cpp
                                   "${PROJECT_SOURCE_DIR}/tests/property/poisson_band/seams.cpp")
target_compile_definitions(bench-seams
                           PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes")
add_dependencies(bench-seams cornice-flightlines)
