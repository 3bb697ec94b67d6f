# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(elevation_model unit/io/elevation_model_test.cpp LIBS cornice_io cornice_test_support)
