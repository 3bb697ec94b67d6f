// SPDX-License-Identifier: GPL-3.0-or-later
// The plane through a neighbourhood by principal components, and how good it is.
#pragma once

#include <array>
#include <cstddef>

#include "core/base/vec.h"
#include "stages/normals/neighbours.h"

namespace cornice::normals {

/// Plane through a neighbourhood.
struct PlaneFit {
  Vec3f normal;          ///< unit, of the sign that makes z (else y, else x) positive; 0 where none
  float quality = 0.0f;  ///< q1 * q2, 0..1
  float breadth_m = 0.0f;  ///< root of the middle eigenvalue: extent across the points' longest way
  float spread_m = 0.0f;   ///< root of the smallest eigenvalue: rms distance from the plane

  bool exists() const { return normal.x != 0.0f || normal.y != 0.0f || normal.z != 0.0f; }
};

/// Planes of kLanes neighbourhoods; the fields of PlaneFit.
struct PlaneBlock {
  std::array<float, kLanes> normal_x, normal_y, normal_z, quality, breadth_m, spread_m;

  PlaneFit plane(std::size_t l) const {
    return {{normal_x[l], normal_y[l], normal_z[l]}, quality[l], breadth_m[l], spread_m[l]};
  }
};

/// Least-squares plane of each lane: the eigenvector of the smallest eigenvalue l0 <= l1 <= l2 of
/// the covariance of the neighbours. q1 = 1 - l0/l1 falls from a disk to a cigar or a ball, and
/// q2 = max(0, 1 - 3 e^2/l2) falls as the point itself lies e metres off the plane. No normal
/// (zero vector, quality 0) for fewer than 3 points and for points on one line. What a lane gives
/// does not depend on the other lanes. `block` must be finished.
/// Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992, section 3.1.
void fit_planes(const NeighbourBlock& block, PlaneBlock& planes);

/// The same of one neighbourhood; for many, a block is several times as fast.
PlaneFit fit_plane(const Neighbourhood& neighbours);

}  // namespace cornice::normals
