# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(drape unit/drape/raster_pyramid_test.cpp unit/drape/tile_choice_test.cpp
             unit/drape/tile_loader_test.cpp
             LIBS cornice_geo cornice_test_support cornice_viewer_drape GDAL::GDAL)
