# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_flightlines e2e/flightlines/flightlines_test.cpp
             LIBS cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_flightlines cornice-flightlines cornice-simulate)
