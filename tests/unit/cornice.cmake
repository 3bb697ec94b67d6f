# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(cornice unit/cornice/front_test.cpp LIBS cornice_test_support)
add_dependencies(test-cornice cornice)
