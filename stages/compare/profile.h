// SPDX-License-Identifier: GPL-3.0-or-later
// Both surfaces where a vertical plane cuts them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "stages/compare/surface.h"

namespace cornice::compare {

/// A line in plan, world.
struct ProfileLine {
  double east1 = 0.0, north1 = 0.0, east2 = 0.0, north2 = 0.0;
  double length() const;
  Box2d box() const;
};

/// A place along the line: metres from its start, and height.
struct ProfilePoint {
  double along_m = 0.0, height_m = 0.0;
};

/// What the plane cuts of each side: segments of surfaces, points of clouds near the line.
struct Profile {
  ProfileLine line;
  std::array<std::vector<std::array<ProfilePoint, 2>>, 2> segments;
  std::array<std::vector<ProfilePoint>, 2> points;
};

/// Adds what the plane cuts of a surface; of clouds the points within `reach_m` of it.
void cut_profile(const Surface& surface, std::size_t side, double reach_m, Profile& profile);

/// The profile as SVG, heights not exaggerated unless it is far longer than high.
std::string profile_svg(const Profile& profile, const std::array<std::string, 2>& names);

}  // namespace cornice::compare
