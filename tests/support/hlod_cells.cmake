# SPDX-License-Identifier: GPL-3.0-or-later
# Cells of hierarchies made up for tests.
cornice_library(test_hlod_cells support/hlod_cells.cpp)
target_link_libraries(cornice_test_hlod_cells PUBLIC cornice_hlod cornice_test_meshes)
