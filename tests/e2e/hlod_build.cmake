# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_hlod_build e2e/hlod/build_test.cpp
             LIBS cornice_io cornice_test_meshes cornice_test_support)
add_dependencies(test-e2e_hlod_build cornice-hlod)
