# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_normals e2e/normals/normals_test.cpp
             LIBS cornice_las cornice_io cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_normals cornice-normals cornice-simulate cornice-flightlines)
