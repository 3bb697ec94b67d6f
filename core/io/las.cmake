# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(las las_info.cpp las_reader.cpp las_writer.cpp copc_writer.cpp)
target_link_libraries(cornice_las PUBLIC cornice_points cornice_geo
                                  PRIVATE LASzip::LASzip GDAL::GDAL)
