# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(viewer_session unit/viewer_session/layers_test.cpp unit/viewer_session/legend_test.cpp
             unit/viewer_session/legend_colours_test.cpp unit/viewer_session/light_test.cpp
             unit/viewer_session/read_out_test.cpp unit/viewer_session/rest_test.cpp
             LIBS cornice_test_hierarchy cornice_test_meshes cornice_test_support
                  cornice_viewer_app GDAL::GDAL)
