# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(las_parts unit/las/laz_chunk_table_test.cpp unit/las/lax_reader_test.cpp
             unit/las/ordered_work_test.cpp unit/las/bad_files_test.cpp
             unit/las/crs_sources_test.cpp property/las_writer/clouds.cpp support/small_files.cpp
             LIBS cornice_las cornice_test_support LASzip::LASzip GDAL::GDAL)
