// SPDX-License-Identifier: GPL-3.0-or-later
// From a text that names a place to a camera that looks at it.
#pragma once

#include <optional>
#include <string>

#include "terrain-viewer/scene/navigation.h"

namespace cornice::viewer {

/// Where a text says to go; `problem` says in one line why there is no place, empty otherwise.
struct PlaceFound {
  std::optional<Vec3d> place;  ///< in the scene's reference system; z 0 where not given
  bool has_height = false;
  std::string problem;
};

/// text: as parse_place reads it. Latitude and longitude are WGS 84. Easting and northing are those
/// of the scene, but numbers that only LV95 (EPSG:2056) or Lambert-93 (EPSG:2154) has are of that
/// system: their ranges do not overlap. scene_crs: as Crs::text(), or empty.
PlaceFound find_place(const std::string& text, const std::string& scene_crs);

/// Looks down on the place from 400 m south and 300 m above; a place without a height lies on the
/// ground, and where there is none at `height_m`.
Camera camera_over(const PlaceFound& found, const Camera& like, const Ground& ground,
                   double height_m);

}  // namespace cornice::viewer
