# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(las_writer property/las_writer/las_writer_test.cpp property/las_writer/copc_writer_test.cpp
             property/las_writer/laszip_oracle.cpp
             property/las_writer/clouds.cpp LIBS cornice_las LASzip::LASzip cornice_test_support)
