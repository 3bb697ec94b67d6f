// SPDX-License-Identifier: GPL-3.0-or-later
// Plan positions from one reference system to another, shifts of the datum included.
#pragma once

#include <optional>

#include "core/base/vec.h"
#include "core/geo/crs.h"

namespace cornice {

/// The place of `position` in another system: easting and northing, of systems in degrees longitude
/// and latitude; z comes back as it was. The most accurate way that PROJ has without reading
/// grids from a network. Nothing where a system is empty or unknown to PROJ, or where the position
/// is outside of its reach.
std::optional<Vec3d> transformed(Vec3d position, const Crs& from, const Crs& to);

}  // namespace cornice
