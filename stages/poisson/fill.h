// SPDX-License-Identifier: GPL-3.0-or-later
// Points of an elevation model where there are no measured ones.
//
//   measured points          │◄─ beyond ─►│ points of the model │◄─ beyond ─►│   measured points
//   · · ·· · · ·· · · · ·· · ·              +    +    +    +    +              · · · ·· · · · ·· ·
//                              the field goes from one to the other here
#pragma once

#include <cstdint>

#include "core/base/vec.h"
#include "core/io/elevation_model.h"
#include "core/mesh/mesh.h"

namespace cornice::poisson {

struct FillOptions {
  /// A place is a gap where no point lies within this distance in plan: so nothing is put under an
  /// overhang, and a step between the model and the points has room to become a slope.
  double beyond_m = 5.0;
  double step_m = 0.5;   ///< of the lattice; points are one to two steps apart
  float quality = 0.5f;  ///< of the points put in; those of the normals stage have at most 1
};

/// Adds points of `model` in the gaps of `points` within `area` (projected, metres), on a grid that
/// all tiles share. Returns how many. Attributes other than normal and quality are 0 there.
std::uint64_t fill_gaps(OrientedPoints& points, const ElevationModel& model, const Box2d& area,
                        const FillOptions& options);

}  // namespace cornice::poisson
