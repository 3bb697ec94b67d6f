# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(pictures unit/pictures/mesh_view_test.cpp LIBS cornice_pictures)
