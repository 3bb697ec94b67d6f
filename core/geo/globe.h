// SPDX-License-Identifier: GPL-3.0-or-later
// Between positions of a projected CRS and the globe, and how far grid north is from true north.
#pragma once

#include <memory>
#include <optional>

#include "core/base/vec.h"
#include "core/geo/crs.h"

namespace cornice {

/// A place by latitude and longitude on the CRS's own datum.
struct GlobePosition {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  /// Azimuth of grid north, clockwise from true north: true azimuth = grid azimuth + convergence.
  double convergence_deg = 0.0;
};

/// Positions of one projected CRS on the globe (PROJ through GDAL; geodesics by GeographicLib).
class Globe {
 public:
  explicit Globe(const Crs& crs);
  ~Globe();
  /// Nothing where the CRS is empty or unknown to PROJ, or the position is outside of its reach.
  std::optional<GlobePosition> at(Vec3d position) const;
  /// The way back, in plan: easting and northing in CRS units, z 0. On the CRS's own datum; nothing
  /// as above.
  std::optional<Vec3d> projected(double latitude_deg, double longitude_deg) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornice
