# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(mesh_file unit/mesh_file/mesh_stream_test.cpp unit/mesh_file/mesh_file_test.cpp
             LIBS cornice_mesh_file cornice_test_meshes cornice_test_support)
