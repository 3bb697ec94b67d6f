# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(poisson_engine bricks.cpp field.cpp)
target_link_libraries(cornice_poisson_engine PUBLIC cornice_base cornice_points)
