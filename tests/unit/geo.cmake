# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(geo unit/geo/crs_test.cpp unit/geo/file_crs_test.cpp unit/geo/globe_test.cpp
             unit/geo/known_crs_test.cpp unit/geo/product_name_test.cpp unit/geo/transform_test.cpp LIBS cornice_geo)
