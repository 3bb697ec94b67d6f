# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_compare e2e/compare/compare_test.cpp
             LIBS cornice_io cornice_las cornice_simulate_scene cornice_mesh cornice_test_support
                  nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_compare cornice-compare cornice)
