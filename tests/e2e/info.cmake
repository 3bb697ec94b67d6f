# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(info_program e2e/info/info_program_test.cpp
             LIBS cornice_las cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-info_program cornice-info)
