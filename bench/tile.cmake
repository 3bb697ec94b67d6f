# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(tile nlohmann_json::nlohmann_json)
target_sources(bench-tile PRIVATE survey_run/survey_run.cpp)
target_compile_definitions(bench-tile PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes"
                                            CORNICE_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
add_dependencies(bench-tile cornice-programs)
