# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_remesh e2e/remesh/program_test.cpp
             LIBS cornice_io cornice_mesh cornice_test_meshes cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_remesh cornice-poisson cornice-remesh)
