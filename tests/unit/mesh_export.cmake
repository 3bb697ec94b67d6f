# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(mesh_export unit/mesh_export/mesh_export_test.cpp
             LIBS cornice_mesh_export cornice_test_meshes cornice_test_support
                  nlohmann_json::nlohmann_json)
