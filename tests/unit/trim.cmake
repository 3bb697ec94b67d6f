# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(trim unit/trim/trim_test.cpp LIBS cornice_trim cornice_test_meshes)
