# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(ply unit/io/ply_test.cpp property/io/ply_round_trip_test.cpp
             LIBS cornice_io cornice_test_support)
cornice_test(raster unit/io/raster_test.cpp unit/io/picture_test.cpp
             LIBS cornice_io cornice_picture cornice_test_support GDAL::GDAL OpenImageIO::OpenImageIO)

find_library(CORNICE_PCL_IO pcl_io)
find_library(CORNICE_PCL_IO_PLY pcl_io_ply)
cornice_test(ply_foreign unit/io/ply_foreign_test.cpp
             LIBS cornice_io cornice_test_support PCL::filters ${CORNICE_PCL_IO}
                  ${CORNICE_PCL_IO_PLY})
