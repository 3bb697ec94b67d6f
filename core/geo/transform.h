// SPDX-License-Identifier: GPL-3.0-or-later
// Plan positions from one reference system to another, shifts of the datum included.
#pragma once

#include <memory>
#include <optional>

#include "core/base/vec.h"
#include "core/geo/crs.h"

namespace cornice {

/// The way from one system to another, made once for many places: making one takes some fifty times
/// as long as using it. For one thread at a time.
class PlanTransform {
 public:
  /// The most accurate way that PROJ has without reading grids from a network.
  PlanTransform(const Crs& from, const Crs& to);

  /// The place of `position` in the other system: easting and northing, of systems in degrees
  /// longitude and latitude; z comes back as it was. Nothing where a system is empty or unknown to
  /// PROJ, or where the position is outside of its reach.
  std::optional<Vec3d> operator()(Vec3d position) const;

 private:
  std::shared_ptr<void> way_;  ///< GDAL's; null where there is none
};

/// The same for a single place.
std::optional<Vec3d> transformed(Vec3d position, const Crs& from, const Crs& to);

}  // namespace cornice
