# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(
  poisson_engine
  bricks.cpp
  closed_brick.cpp
  composite.cpp
  constraints.cpp
  density.cpp
  equations.cpp
  field.cpp
  grid.cpp
  misfit.cpp
  near.cpp
  relax.cpp
  samples.cpp
  screening.cpp
  solve.cpp)
target_link_libraries(cornice_poisson_engine PUBLIC cornice_base cornice_points)
