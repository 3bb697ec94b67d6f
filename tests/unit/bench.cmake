# SPDX-License-Identifier: GPL-3.0-or-later
# The library exists only where benchmarks are built.
if(CORNICE_BUILD_BENCH)
  cornice_test(bench unit/bench/programs_test.cpp LIBS cornice_bench)
endif()
