# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(compare unit/compare/distance_test.cpp unit/compare/grid_test.cpp
             unit/compare/m3c2_test.cpp unit/compare/overhang_test.cpp
             unit/compare/source_test.cpp unit/compare/statistics_test.cpp
             unit/compare/pieces.cpp
             LIBS cornice_compare_output cornice_compare cornice_las cornice_test_meshes cornice_test_support)
