# SPDX-License-Identifier: GPL-3.0-or-later
# Meshes of known shape, for tests and benchmarks.
cornice_library(test_meshes support/meshes.cpp)
target_link_libraries(cornice_test_meshes PUBLIC cornice_mesh)
