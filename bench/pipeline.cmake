# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(pipeline nlohmann_json::nlohmann_json)
target_sources(bench-pipeline PRIVATE survey_run/survey_run.cpp)
target_compile_definitions(bench-pipeline PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes"
                                            CORNICE_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
add_dependencies(bench-pipeline cornice-programs)
