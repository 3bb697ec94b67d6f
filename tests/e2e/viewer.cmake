# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_viewer e2e/viewer/program_test.cpp
             LIBS cornice_io cornice_test_meshes cornice_test_picture cornice_test_support
                  cornice_viewer_scene nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_viewer cornice-hlod cornice-viewer)
add_test(NAME e2e.viewer_window COMMAND /usr/bin/python3 -B
         "${PROJECT_SOURCE_DIR}/tests/e2e/viewer/window_test.py" "${CMAKE_BINARY_DIR}/bin")
set_tests_properties(e2e.viewer_window PROPERTIES TIMEOUT 3600)
