# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(viewer_window unit/viewer_window/dropped_files_test.cpp
             unit/viewer_window/failure_log_test.cpp unit/viewer_window/frame_pacer_test.cpp
             unit/viewer_window/gamepad_test.cpp
             unit/viewer_window/key_actions_test.cpp unit/viewer_window/new_file_test.cpp
             unit/viewer_window/pilot_test.cpp unit/viewer_window/read_out_test.cpp
             unit/viewer_window/screens_test.cpp unit/viewer_window/swipe_line_test.cpp
             LIBS cornice_test_hierarchy cornice_test_meshes cornice_test_support cornice_viewer_app
                  GDAL::GDAL glfw::glfw)
