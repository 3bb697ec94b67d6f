# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_stitch e2e/stitch/stitch_test.cpp property/stitch/tiles.cpp
             LIBS cornice_io cornice_mesh cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_stitch cornice-stitch)
