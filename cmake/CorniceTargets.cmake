# SPDX-License-Identifier: GPL-3.0-or-later
# How this project declares its own targets: warnings as errors, sanitizers, one include root.

find_program(CORNICE_CCACHE ccache)
if(CORNICE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CORNICE_CCACHE}")
  set(CMAKE_C_COMPILER_LAUNCHER "${CORNICE_CCACHE}")
endif()

if(CORNICE_SANITIZE)
  add_compile_options(-fsanitize=${CORNICE_SANITIZE} -fno-omit-frame-pointer -g
                      -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${CORNICE_SANITIZE})
endif()

function(cornice_configure target)
  target_include_directories(${target} PUBLIC "${PROJECT_SOURCE_DIR}")
  # -ffp-contract=off: the same arithmetic whatever the compiler fuses, so the same bytes.
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                           -Wno-sign-conversion -Werror -ffp-contract=off)
  # g++ 12 warns of "text" + std::string, falsely (GCC bug 105329).
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
  if(CORNICE_NATIVE)
    target_compile_options(${target} PRIVATE -march=native)
  endif()
endfunction()

# cornice_library(name SOURCES... ): a static library cornice_<name>.
function(cornice_library name)
  add_library(cornice_${name} STATIC ${ARGN})
  cornice_configure(cornice_${name})
endfunction()

# What the demo runs, without tests and benchmarks.
add_custom_target(cornice-programs)

# cornice_stage(name LIBS... ): the executable cornice-<name> from main.cpp in this folder.
function(cornice_stage name)
  add_executable(cornice-${name} main.cpp)
  add_dependencies(cornice-programs cornice-${name})
  cornice_configure(cornice-${name})
  target_link_libraries(cornice-${name} PRIVATE cornice_cli ${ARGN})
  install(TARGETS cornice-${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
