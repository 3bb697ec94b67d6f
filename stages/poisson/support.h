// SPDX-License-Identifier: GPL-3.0-or-later
// How well measured points hold up a surface.
#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/mesh/mesh.h"

namespace cornice {

struct SupportOptions {
  double cap_m = 16.0;    ///< distances are exact up to here, and this beyond; > 0
  double radius_m = 1.0;  ///< of the ball whose points make the density; > 0
  int threads = 0;        ///< 0: all cores
};

/// By vertex.
struct Support {
  std::vector<float> distance_m;  ///< to the nearest point, at most the cap
  /// Points within the radius over the area of a disc of that radius: on a surface that is flat
  /// there, points per square metre of it. Points/m².
  std::vector<float> density;
};

/// Support of every vertex of `mesh` by `points`; points that are not finite do not count. The same
/// for any number of threads. Memory: 16 bytes a point near the mesh, and 8 bytes for each square
/// of radius_m under it.
Support measure_support(const Mesh& mesh, const OrientedPoints& points,
                        const SupportOptions& options, Progress& progress = no_progress());

}  // namespace cornice
