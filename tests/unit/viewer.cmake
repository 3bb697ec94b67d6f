# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(viewer unit/viewer/camera_memory_test.cpp unit/viewer/camera_test.cpp unit/viewer/controls_test.cpp
             unit/viewer/go_to_test.cpp unit/viewer/input_queue_test.cpp unit/viewer/navigation_test.cpp
             unit/viewer/range_allocator_test.cpp unit/viewer/scale_bar_test.cpp
             unit/viewer/scene_test.cpp unit/viewer/sun_test.cpp unit/viewer/viewpoint_test.cpp LIBS cornice_viewer_app
             cornice_test_support)
