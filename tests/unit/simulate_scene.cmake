# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(simulate_scene_parts ${CMAKE_CURRENT_LIST_DIR}/simulate_scene/scene_file_test.cpp
             ${CMAKE_CURRENT_LIST_DIR}/simulate_scene/scene_parts_test.cpp LIBS
             cornice_simulate_scene cornice_base cornice_test_support)
