# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(poisson_command e2e/poisson_command/command_test.cpp
             LIBS cornice_io cornice_mesh cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-poisson_command cornice-poisson)
