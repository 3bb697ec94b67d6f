# SPDX-License-Identifier: GPL-3.0-or-later
add_executable(test-probe-stage unit/cli/probe_stage.cpp)
cornice_configure(test-probe-stage)
target_link_libraries(test-probe-stage PRIVATE cornice_cli)
cornice_test(cli unit/cli/command_line_test.cpp unit/cli/options_test.cpp
             unit/cli/output_place_test.cpp unit/cli/progress_test.cpp unit/cli/report_test.cpp
             unit/cli/stage_test.cpp
             LIBS cornice_cli cornice_test_support)
target_compile_definitions(test-cli PRIVATE CORNICE_VERSION="${PROJECT_VERSION}")
add_dependencies(test-cli test-probe-stage)
