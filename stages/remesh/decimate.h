// SPDX-License-Identifier: GPL-3.0-or-later
// The first, rough reduction: half-edge collapses by quadric error.
#pragma once

#include <vector>

#include "stages/remesh/guard.h"
#include "stages/remesh/patches.h"

namespace cornice::remesh {

struct DecimateLimits {
  float error_m = 0.02f;  ///< root mean square distance of a vertex from the planes it stands for
  float edge_m = 20.0f;   ///< longest edge to make
  GuardLimits guard;
};

/// Collapses vertices that are not fixed onto neighbours, in rounds, cheapest first, as far as
/// `guard` lets them. In one round no vertex goes that another has gone onto: its cost is old.
/// Vertices keep their place and number, which in patch.vertices is that of the input; the
/// triangles that are left are returned, and what they carry is in `guard`. Takes patch.triangles.
/// Every vertex that is not fixed must be inside a closed ring of triangles. No collapse joins two
/// fixed vertices by a new edge: outside the patch there may be one already. Garland, Heckbert
/// 1997; quadrics are held relative to their vertex, so floats suffice.
std::vector<Triangle> decimate(const std::vector<Vec3f>& positions, Patch& patch,
                               const Reference& input, const DecimateLimits& limits, Guard& guard);

}  // namespace cornice::remesh
