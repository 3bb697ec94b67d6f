# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(ply unit/io/ply_test.cpp property/io/ply_round_trip_test.cpp
             LIBS cornice_io cornice_test_support)
cornice_test(raster unit/io/raster_test.cpp unit/io/picture_test.cpp
             LIBS cornice_io cornice_test_support GDAL::GDAL OpenImageIO::OpenImageIO)
