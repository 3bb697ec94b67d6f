# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(poisson_extract band.cpp band_file.cpp extract.cpp extract_brick.cpp
                                extract_polygon.cpp extract_table.cpp extract_values.cpp
                                support.cpp)
target_link_libraries(cornice_poisson_extract PUBLIC cornice_poisson_engine cornice_base
                                              PRIVATE xxhash::xxhash)
