// SPDX-License-Identifier: GPL-3.0-or-later
// Coarser levels hear of finer ones. A level that was solved on its own draws the finer level's rim
// to where its own coarse surface lies. So the field of all levels together is held to minimise the
// energy: with nested spaces, u = interpolation of the coarser level + details, and the equation of
// a coarse node i is
//   A u_coarse + restriction of (A details + screening of the finer level) = constraints.
// A. Brandt, "Multi-level adaptive solutions to boundary-value problems", 1977.
#pragma once

#include <span>

#include "stages/poisson/grid.h"
#include "stages/poisson/screening.h"

namespace cornice::poisson {

/// Tells a coarser level what a finer one has found: sets coarse.values where they share nodes, and
/// coarse.right_side to what the finer levels leave for it. `fine` then holds, at nodes that coarse
/// has not, what they differ from its interpolation, until lower(). For levels above the finest,
/// fine.right_side must have been set by a raise() before; finish_raise() ends the chain.
void raise(Grid& fine, const Screening& fine_screening, Grid& coarse, bool fine_is_finest,
           int threads);
/// Makes right_side of the coarsest level of a chain of raise().
void finish_raise(Grid& coarsest, const Screening& screening, int threads);

/// Undoes what raise() did to `fine`, with the coarser levels' values as they are now.
void lower(Grid& fine, std::span<const LevelView> coarser, int threads);

}  // namespace cornice::poisson
