// SPDX-License-Identifier: GPL-3.0-or-later
// The orientation of normals compiled for the least processor alone.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec.h"

namespace cornice::test {

/// What orient_normals says of N points in the order of the curve.
struct PlainOrientation {
  std::vector<Vec3f> directions;
  std::vector<float> quality;
  std::vector<std::uint8_t> settled_by;
};

/// `positions` in the order of the curve; beams from trajectories, N.
PlainOrientation orient_without_clones(const std::vector<Vec3f>& positions,
                                       const std::vector<Vec3f>& beams);

}  // namespace cornice::test
