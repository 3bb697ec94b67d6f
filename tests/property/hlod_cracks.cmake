# SPDX-License-Identifier: GPL-3.0-or-later
if(CORNICE_BUILD_BENCH)
  cornice_test(hlod_cracks property/hlod/cluster_hierarchy.cpp property/hlod/cracks_test.cpp
               property/hlod/file_check_test.cpp
               LIBS cornice_cracks_checker cornice_mesh cornice_test_meshes cornice_test_hlod_cells cornice_test_support)
endif()
