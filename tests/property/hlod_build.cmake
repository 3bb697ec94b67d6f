# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(hlod_build unit/hlod/simplify_test.cpp unit/hlod/simplify_links_test.cpp unit/hlod/build_spool_test.cpp
             property/hlod/build_test.cpp
             LIBS cornice_hlod cornice_io cornice_mesh cornice_test_meshes cornice_test_support)
