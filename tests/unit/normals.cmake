# SPDX-License-Identifier: GPL-3.0-or-later
# The chain once more without clones, under another name so that both can be linked.
add_library(cornice_normals_one_version STATIC unit/normals/one_version.cpp)
foreach(file IN ITEMS bend_fit faces leaf_search morton_order neighbours orient plane_fit point_tree propagate
                      search_kernels witnesses)
  target_sources(cornice_normals_one_version PRIVATE "${PROJECT_SOURCE_DIR}/stages/normals/${file}.cpp")
endforeach()
target_compile_definitions(cornice_normals_one_version PRIVATE CORNICE_ONE_VERSION normals=one_version)
cornice_configure(cornice_normals_one_version)
target_link_libraries(cornice_normals_one_version PRIVATE cornice_points)

cornice_test(normals unit/normals/bend_fit_test.cpp unit/normals/clones_test.cpp unit/normals/class_filter_test.cpp
             unit/normals/normals_test.cpp unit/normals/orient_test.cpp unit/normals/plane_fit_test.cpp
             unit/normals/point_tree_test.cpp
             LIBS cornice_normals cornice_normals_one_version PCL::filters flann::flann cornice_test_support)
