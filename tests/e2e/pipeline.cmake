# SPDX-License-Identifier: GPL-3.0-or-later
add_test(NAME e2e.pipeline COMMAND /usr/bin/python3 -B
         "${PROJECT_SOURCE_DIR}/tests/e2e/pipeline/pipeline_test.py" "${CMAKE_BINARY_DIR}/bin")
set_tests_properties(e2e.pipeline PROPERTIES TIMEOUT 3600)
