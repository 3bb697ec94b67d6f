# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(index unit/index/box_finder_test.cpp unit/index/tile_boxes_test.cpp
             unit/index/survey_index_test.cpp
             LIBS cornice_index cornice_las cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-index cornice-index)
