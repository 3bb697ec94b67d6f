# SPDX-License-Identifier: GPL-3.0-or-later
# The checker is a library of its own because the property tests use it too.
cornice_library(cracks_checker cracks/checker.cpp cracks/random_views.cpp)
target_link_libraries(cornice_cracks_checker PUBLIC cornice_hlod)
if(CORNICE_BUILD_TESTS)
  # Its made-up meshes are those of the tests.
  cornice_add_bench(cracks cornice_cracks_checker cornice_hlod cornice_simulate_survey cornice_simulate_scene
                    cornice_test_meshes)
  target_sources(bench-cracks PRIVATE cracks/subjects.cpp)
  target_compile_definitions(bench-cracks PRIVATE CORNICE_SCENES="${PROJECT_SOURCE_DIR}/samples/scenes")
endif()
