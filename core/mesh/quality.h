// SPDX-License-Identifier: GPL-3.0-or-later
// Shapes of triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice {

/// Cosine of the largest angle is not needed; the smallest angle says whether a triangle is thin.
/// Degrees, 60 at best, 0 for a triangle without area.
double smallest_angle_deg(Vec3d a, Vec3d b, Vec3d c);

/// Twice the inradius by the circumradius: 1 for equal sides, 0 without area.
double radius_ratio(Vec3d a, Vec3d b, Vec3d c);

/// Shapes of the triangles of a mesh.
struct QualityReport {
  std::uint64_t triangles = 0;
  double smallest_angle_deg = 0.0;  ///< of all
  double mean_smallest_angle_deg = 0.0;
  double mean_radius_ratio = 0.0;
  double smallest_radius_ratio = 0.0;
  std::uint64_t below_20_deg = 0;
  std::uint64_t without_area = 0;  ///< smallest angle below 0.01 degrees
  double shortest_edge_m = 0.0;
  double longest_edge_m = 0.0;
  /// Share of triangles whose smallest angle is at least 20 degrees; 1 where there are none.
  double share_min_angle_20() const {
    return triangles == 0
               ? 1.0
               : 1.0 - static_cast<double>(below_20_deg) / static_cast<double>(triangles);
  }
};

/// Of all triangles, or of those whose byte in `chosen` (empty, or #T) is not 0.
QualityReport measure_quality(const std::vector<Vec3f>& positions,
                              const std::vector<Triangle>& triangles, int threads,
                              const std::vector<std::uint8_t>& chosen = {});

}  // namespace cornice
