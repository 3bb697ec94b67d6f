# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(remesh_self_intersection property/remesh/self_intersection_test.cpp
             LIBS cornice_remesh cornice_test_meshes CGAL::headers)
