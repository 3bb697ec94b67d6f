# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(dem unit/dem/grid_surface_test.cpp unit/dem/layers_test.cpp unit/dem/mesh_raster_test.cpp
             LIBS cornice_dem cornice_mesh cornice_test_meshes)
