# SPDX-License-Identifier: GPL-3.0-or-later
# Files of hierarchies, built of a mesh.
cornice_library(test_hierarchy support/hierarchy.cpp)
target_link_libraries(cornice_test_hierarchy PUBLIC cornice_hlod)
