# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(test_picture support/perceived.cpp support/picture.cpp)
target_link_libraries(cornice_test_picture PUBLIC cornice_io PRIVATE OpenImageIO::OpenImageIO)
