# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(remesh unit/remesh/change_test.cpp unit/remesh/guard_test.cpp unit/remesh/patch_mesh_test.cpp
             unit/remesh/remesh_test.cpp
             LIBS cornice_remesh cornice_test_meshes CGAL::headers)
