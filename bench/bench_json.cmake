# SPDX-License-Identifier: GPL-3.0-or-later
# cornice_bench: options and JSON of every bench, and how they run programs.
# cornice_add_bench(name LIBS...) adds bench-<name> from <name>.cpp in this folder.
add_library(cornice_bench STATIC bench_json.cpp programs.cpp)
cornice_configure(cornice_bench)
target_compile_definitions(cornice_bench PRIVATE CORNICE_BUILD_TYPE="${CMAKE_BUILD_TYPE}")
target_link_libraries(cornice_bench PUBLIC cornice_base CLI11::CLI11
                                    PRIVATE cornice_cli nlohmann_json::nlohmann_json)

function(cornice_add_bench name)
  add_executable(bench-${name} ${name}.cpp)
  cornice_configure(bench-${name})
  target_link_libraries(bench-${name} PRIVATE cornice_bench ${ARGN})
endfunction()
