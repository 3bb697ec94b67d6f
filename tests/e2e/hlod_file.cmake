# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(e2e_hlod_file e2e/hlod_file/hlod_file_test.cpp
             LIBS cornice_io cornice_test_meshes cornice_test_support nlohmann_json::nlohmann_json)
add_dependencies(test-e2e_hlod_file cornice-hlod)
