# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_drape e2e/drape/drape_test.cpp
             LIBS cornice_io cornice_test_meshes cornice_test_picture cornice_test_support
                  cornice_viewer_scene GDAL::GDAL nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_drape cornice-hlod cornice-viewer)
