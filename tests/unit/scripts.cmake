# SPDX-License-Identifier: GPL-3.0-or-later
find_package(Python3 REQUIRED COMPONENTS Interpreter)
foreach(subject setup)
  add_test(NAME scripts.${subject}
           COMMAND "${Python3_EXECUTABLE}" -B
                   "${PROJECT_SOURCE_DIR}/tests/unit/scripts/${subject}_test.py")
  set_tests_properties(scripts.${subject} PROPERTIES TIMEOUT 300)
endforeach()
