// SPDX-License-Identifier: GPL-3.0-or-later
// The plane through a neighbourhood by principal components, and how good it is.
#pragma once

#include "core/base/vec.h"
#include "stages/normals/point_tree.h"

namespace cornice::normals {

/// Plane through a neighbourhood.
struct PlaneFit {
  Vec3f normal;          ///< unit, of the sign that makes z (else y, else x) positive; 0 where none
  float quality = 0.0f;  ///< q1 * q2, 0..1
  float breadth_m = 0.0f;  ///< root of the middle eigenvalue: extent across the points' longest way
  float spread_m = 0.0f;   ///< root of the smallest eigenvalue: rms distance from the plane
};

/// Least-squares plane: the eigenvector of the smallest eigenvalue l0 <= l1 <= l2 of the
/// covariance of the neighbours. q1 = 1 - l0/l1 falls from a disk to a cigar or a ball, and
/// q2 = max(0, 1 - 3 e^2/l2) falls as the point itself lies e metres off the plane. No normal
/// (zero vector, quality 0) for fewer than 3 points and for points on one line.
/// Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992, section 3.1.
PlaneFit fit_plane(const Neighbourhood& neighbours);

}  // namespace cornice::normals
