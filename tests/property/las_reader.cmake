# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(las_reader property/las/real_files_test.cpp support/laszip_oracle.cpp
             LIBS cornice_las LASzip::LASzip)
