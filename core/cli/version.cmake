# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -D SOURCE_DIR= -D TEMPLATE= -D OUTPUT= -D CORNICE_VERSION= -D CORNICE_BUILD= -P version.cmake
# Writes OUTPUT where its content changes, so that an unchanged commit compiles nothing.
find_package(Git QUIET)
set(CORNICE_COMMIT "")
# A release unpacked inside somebody else's repository must not take that one's commit.
if(GIT_FOUND AND EXISTS "${SOURCE_DIR}/.git")
  execute_process(
    COMMAND "${GIT_EXECUTABLE}" --no-optional-locks -C "${SOURCE_DIR}" describe --always --tags
            --dirty
    OUTPUT_VARIABLE CORNICE_COMMIT
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
configure_file("${TEMPLATE}" "${OUTPUT}" @ONLY)
