# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(orientation cornice_normals cornice_io cornice_picture cornice_las PCL::filters
                  nlohmann_json::nlohmann_json)
target_sources(bench-orientation PRIVATE orientation/peers.cpp orientation/picture.cpp
                                         orientation/score.cpp orientation/survey.cpp)
target_compile_definitions(bench-orientation
                           PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes"
                                   CORNICE_OWN_SCENES="${PROJECT_SOURCE_DIR}/bench/orientation/scenes")
add_dependencies(bench-orientation cornice-simulate)
if(TARGET cornice-flightlines)
  add_dependencies(bench-orientation cornice-flightlines)
endif()
