# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(dem-vs-lidar cornice_bench_truth cornice_las cornice_io nlohmann_json::nlohmann_json)
target_sources(bench-dem-vs-lidar PRIVATE survey_run/survey_run.cpp)
target_compile_definitions(
  bench-dem-vs-lidar PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes"
                             CORNICE_TEST_DATA="${CORNICE_TEST_DATA}")
add_dependencies(bench-dem-vs-lidar cornice-programs)
