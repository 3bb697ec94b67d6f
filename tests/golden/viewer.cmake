# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(viewer_golden golden/viewer/pictures_test.cpp golden/viewer/stage.cpp
             property/viewer/crater.cpp
             LIBS cornice_test_hierarchy cornice_test_meshes cornice_test_picture
                  cornice_test_support cornice_viewer_app GDAL::GDAL)
