# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(normals unit/normals/class_filter_test.cpp unit/normals/normals_test.cpp
             unit/normals/orient_test.cpp unit/normals/plane_fit_test.cpp
             unit/normals/point_tree_test.cpp
             LIBS cornice_normals PCL::filters flann::flann cornice_test_support)
