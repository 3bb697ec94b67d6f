# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_fill_dem e2e/trim/fill_test.cpp
             LIBS cornice_io cornice_mesh cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_fill_dem cornice-poisson cornice-trim)
cornice_test(e2e_trim e2e/trim/program_test.cpp
             LIBS cornice_io cornice_test_meshes cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_trim cornice-trim)
