# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(viewer_pictures property/viewer/crater.cpp property/viewer/budget_test.cpp
             property/viewer/changed_files_test.cpp
             property/viewer/holes_test.cpp
             property/viewer/level_colours_test.cpp property/viewer/popping_test.cpp
             LIBS cornice_test_hierarchy cornice_test_meshes cornice_test_picture
                  cornice_test_support cornice_viewer_app)
