// SPDX-License-Identifier: GPL-3.0-or-later
// What the beams of a neighbourhood say about the sides of its plane.
#pragma once

#include <array>
#include <vector>

#include "core/base/vec.h"
#include "core/points/flight_line.h"
#include "stages/normals/plane_fit.h"

namespace cornice::normals {

/// Beams of N points.
struct Beams {
  std::vector<Vec3f> direction;    ///< unit, from sensor to point
  std::vector<BeamSource> source;  ///< what it is known from
};

/// Weighted mean of n . b over each lane's neighbourhood, less what the doubt about each beam may
/// contribute; -1..1, negative where the beams come from the side that n points to. A beam counts
/// half where its point lies as far from the plane as the neighbourhood's spread. Lanes without a
/// plane get 0. `block` must be finished.
std::array<float, kLanes> mean_cosines(const NeighbourBlock& block, const PlaneBlock& planes,
                                       const Beams& beams);

}  // namespace cornice::normals
