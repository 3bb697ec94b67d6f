# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(hlod cornice_hlod cornice_io)
# The yardstick of simplification; the bench says less without it.
find_library(CORNICE_MESHOPTIMIZER meshoptimizer)
find_path(CORNICE_MESHOPTIMIZER_INCLUDE meshoptimizer.h)
if(CORNICE_MESHOPTIMIZER AND CORNICE_MESHOPTIMIZER_INCLUDE)
  target_compile_definitions(bench-hlod PRIVATE CORNICE_HAS_MESHOPTIMIZER)
  target_include_directories(bench-hlod SYSTEM PRIVATE "${CORNICE_MESHOPTIMIZER_INCLUDE}")
  target_link_libraries(bench-hlod PRIVATE "${CORNICE_MESHOPTIMIZER}")
endif()
