# SPDX-License-Identifier: GPL-3.0-or-later
foreach(subject configuration figures report run watch)
  add_test(NAME pipeline.${subject}
           COMMAND /usr/bin/python3 -B
                   "${PROJECT_SOURCE_DIR}/tests/unit/pipeline/${subject}_test.py")
  set_tests_properties(pipeline.${subject} PROPERTIES TIMEOUT 3600)
endforeach()
