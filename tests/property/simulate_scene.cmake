# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(simulate_scene ${CMAKE_CURRENT_LIST_DIR}/simulate_scene/scene_test.cpp LIBS
             cornice_simulate_scene cornice_base cornice_test_support)
