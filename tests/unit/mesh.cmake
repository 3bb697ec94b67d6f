# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(mesh unit/mesh/topology_test.cpp unit/mesh/triangle_tree_test.cpp unit/mesh/quality_test.cpp
             LIBS cornice_mesh cornice_test_meshes CGAL::headers)
