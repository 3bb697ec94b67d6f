# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(las_reader property/las/real_files_test.cpp property/las/windows_test.cpp
             support/laszip_oracle.cpp support/small_files.cpp property/las_writer/clouds.cpp
             LIBS cornice_las cornice_test_support LASzip::LASzip GDAL::GDAL)
