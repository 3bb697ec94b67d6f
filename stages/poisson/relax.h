// SPDX-License-Identifier: GPL-3.0-or-later
// Relaxation of one level's equations.
#pragma once

#include "stages/poisson/grid.h"
#include "stages/poisson/screening.h"

namespace cornice::poisson {

/// Runs `passes` over all bricks. The same for any number of threads.
void relax(Grid& grid, const Screening& screening, int passes, int threads);

/// Root mean squares over the active nodes.
struct Residual {
  double left = 0.0;  ///< of the equations' residual
  double zero = 0.0;  ///< of what it would be for a field of zero
};
Residual residual(const Grid& grid, const Screening& screening, int threads);

}  // namespace cornice::poisson
