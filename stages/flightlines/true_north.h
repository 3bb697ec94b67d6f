// SPDX-License-Identifier: GPL-3.0-or-later
// Where a projected position lies on the globe, and how far grid north is from true north there.
#pragma once

#include <memory>
#include <optional>

#include "core/base/vec.h"
#include "core/geo/crs.h"

namespace cornice::flightlines {

struct GlobePosition {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  /// Azimuth of grid north, clockwise from true north: true azimuth = grid azimuth + convergence.
  double convergence_deg = 0.0;
};

/// Positions of one projected CRS on the globe (PROJ through GDAL; geodesics by GeographicLib).
class TrueNorth {
 public:
  explicit TrueNorth(const Crs& crs);
  ~TrueNorth();
  /// Nothing where the CRS is empty or unknown to PROJ, or the position is outside of its reach.
  std::optional<GlobePosition> at(Vec3d position) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornice::flightlines
