// SPDX-License-Identifier: GPL-3.0-or-later
// Relaxation of one level's equations.
#pragma once

#include <vector>

#include "stages/poisson/grid.h"
#include "stages/poisson/screening.h"

namespace cornice::poisson {

/// Runs `passes` over all bricks; `right_side` has 512 numbers a brick, as grid.constraints. The
/// same for any number of threads.
void relax(Grid& grid, const std::vector<float>& right_side, const Screening& screening, int passes,
           int threads);

/// Root mean squares over the active nodes.
struct Residual {
  double left = 0.0;  ///< of the equations' residual
  double zero = 0.0;  ///< of what it would be for a field of zero
};
Residual residual(const Grid& grid, const Screening& screening, int threads);

}  // namespace cornice::poisson
