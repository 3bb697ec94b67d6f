# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(points unit/points/point_cloud_test.cpp LIBS cornice_points)
