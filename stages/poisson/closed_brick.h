// SPDX-License-Identifier: GPL-3.0-or-later
// Reading a brick and its far faces from levels of bricks, of which any may be missing.
#pragma once

#include <span>

#include "stages/poisson/bricks.h"

namespace cornice {

/// One level of a sparse grid, held by somebody else.
struct LevelView {
  std::span<const BrickKey> bricks;
  const BrickIndex* index = nullptr;
  std::span<const float> values;  ///< 512 a brick, x fastest
};

/// Writes the 9 x 9 x 9 nodes of `brick` of levels[0], x fastest; each next level has twice the
/// spacing. Nodes that a level does not hold are interpolated trilinearly from the next one, with
/// the same bits whichever brick they are read with. False where no level covers all of them; the
/// values are then unspecified.
bool read_closed_brick(std::span<const LevelView> levels, BrickKey brick,
                       std::span<float, kClosedBrickNodes> values);

}  // namespace cornice
