# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(poisson_engine_fields ${CMAKE_CURRENT_LIST_DIR}/poisson_engine/solve_test.cpp
             ${CMAKE_CURRENT_LIST_DIR}/poisson_engine/degenerate_test.cpp
             LIBS cornice_poisson_engine)
