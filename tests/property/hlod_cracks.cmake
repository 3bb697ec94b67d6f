# SPDX-License-Identifier: GPL-3.0-or-later
if(CORNICE_BUILD_BENCH)
  cornice_test(hlod_cracks property/hlod/cluster_hierarchy.cpp property/hlod/cracks_test.cpp
               LIBS cornice_cracks_checker cornice_mesh cornice_test_meshes cornice_test_hlod_cells)
endif()
