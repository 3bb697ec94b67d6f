// SPDX-License-Identifier: GPL-3.0-or-later
// Where the sun stands at a time and place (libnova).
#pragma once

#include <optional>
#include <string>

namespace cornice::viewer {

struct SunPosition {
  double azimuth_deg = 315.0;   ///< clockwise from true north
  double elevation_deg = 45.0;  ///< above the horizon, without refraction
};

/// time: "2026-06-21T10:00:00Z", UTC. Nothing where the text is no such time.
std::optional<SunPosition> sun_at(const std::string& time, double latitude_deg,
                                  double longitude_deg);

}  // namespace cornice::viewer
