// SPDX-License-Identifier: GPL-3.0-or-later
// Where the sun stands at a time and place (libnova), and what light comes from there.
#pragma once

#include <optional>
#include <string>

#include "core/base/vec.h"

namespace cornice::viewer {

struct SunPosition {
  double azimuth_deg = 315.0;   ///< clockwise from true north
  double elevation_deg = 45.0;  ///< above the horizon, without refraction
};

/// time: "2026-06-21T10:00:00Z", UTC. Nothing where the text is no such time.
std::optional<SunPosition> sun_at(const std::string& time, double latitude_deg,
                                  double longitude_deg);

/// The light of a clear day, of dusk, and of a night in which there is still something to be seen.
struct Daylight {
  double sun = 1.0;   ///< share of its light that comes through, 0 from somewhat below the horizon
  Vec3d sun_colour;   ///< of its light, linear; red is 1
  Vec3d sky, ground;  ///< light from above and from below
  Vec3d haze;         ///< air far away, sRGB
  double warmth = 0;  ///< how far air below the sun takes the colour of its light
};
Daylight daylight(double sine_of_elevation);

}  // namespace cornice::viewer
