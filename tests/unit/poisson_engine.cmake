# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(poisson_engine ${CMAKE_CURRENT_LIST_DIR}/poisson_engine/bricks_test.cpp
             ${CMAKE_CURRENT_LIST_DIR}/poisson_engine/field_test.cpp
             ${CMAKE_CURRENT_LIST_DIR}/poisson_engine/misfit_test.cpp LIBS cornice_poisson_engine)
