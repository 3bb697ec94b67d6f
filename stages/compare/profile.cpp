// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/profile.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "stages/compare/svg.h"

namespace cornice::compare {
namespace {

constexpr double kWidthPx = 1000.0;
constexpr double kHighestPx = 520.0, kLowestPx = 220.0;
constexpr double kLeftPx = 64.0, kRightPx = 16.0, kTopPx = 34.0, kBottomPx = 44.0;
constexpr std::array<const char*, 2> kColours{"#c2571a", "#1b5fa8"};

/// The line's frame: along it, across it to the left, up.
struct LineFrame {
  Vec3d start, along, across;
  double length;
};

LineFrame frame_of_line(const ProfileLine& line, Vec3d origin) {
  const double length = line.length();
  const Vec3d along{(line.east2 - line.east1) / length, (line.north2 - line.north1) / length, 0.0};
  return {Vec3d{line.east1, line.north1, 0.0} - origin, along, {-along.y, along.x, 0.0}, length};
}

/// Cuts a segment to 0..length; false where nothing is left.
bool clip(ProfilePoint& a, ProfilePoint& b, double length) {
  if (a.along_m > b.along_m) std::swap(a, b);
  if (b.along_m < 0.0 || a.along_m > length) return false;
  const auto at = [&](double s) {
    const double share = (s - a.along_m) / (b.along_m - a.along_m);
    return ProfilePoint{s, a.height_m + share * (b.height_m - a.height_m)};
  };
  if (a.along_m < 0.0) a = at(0.0);
  if (b.along_m > length) b = at(length);
  return true;
}

}  // namespace

double ProfileLine::length() const { return std::hypot(east2 - east1, north2 - north1); }

Box2d ProfileLine::box() const {
  Box2d box;
  box.add(east1, north1);
  box.add(east2, north2);
  return box;
}

void cut_profile(const Surface& surface, std::size_t side, double reach_m, Profile& profile) {
  const LineFrame frame = frame_of_line(profile.line, surface.origin);
  const auto seen = [&](std::uint32_t v) {
    const Vec3d p = surface.positions[v].cast<double>() - frame.start;
    return Vec3d{dot(p, frame.along), dot(p, frame.across),
                 surface.origin.z + static_cast<double>(surface.positions[v].z)};
  };
  if (surface.triangles.empty()) {
    for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
      const Vec3d p = seen(v);
      if (std::abs(p.y) > reach_m || p.x < 0.0 || p.x > frame.length) continue;
      profile.points[side].push_back({p.x, p.z});
    }
    return;
  }
  for (const Triangle& t : surface.triangles) {
    const std::array<Vec3d, 3> p{seen(t[0]), seen(t[1]), seen(t[2])};
    std::array<ProfilePoint, 2> ends;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3 && count < 2; ++k) {
      const Vec3d &a = p[k], &b = p[(k + 1) % 3];
      // Half-open, so that a corner on the line is met once.
      if ((a.y < 0.0) == (b.y < 0.0)) continue;
      const double share = a.y / (a.y - b.y);
      ends[count++] = {a.x + share * (b.x - a.x), a.z + share * (b.z - a.z)};
    }
    if (count == 2 && clip(ends[0], ends[1], frame.length)) profile.segments[side].push_back(ends);
  }
}

std::string profile_svg(const Profile& profile, const std::array<std::string, 2>& names) {
  double low = 1e300, high = -1e300;
  const auto widen = [&](const ProfilePoint& p) {
    low = std::min(low, p.height_m), high = std::max(high, p.height_m);
  };
  for (const std::size_t side : {0u, 1u}) {
    for (const auto& segment : profile.segments[side]) widen(segment[0]), widen(segment[1]);
    for (const ProfilePoint& p : profile.points[side]) widen(p);
  }
  if (low > high) low = high = 0.0;
  const double rise = std::max(high - low, 1.0);
  const double length = std::max(profile.line.length(), 1e-3);
  const double plot_width = kWidthPx - kLeftPx - kRightPx;
  const double plot_height = std::clamp(plot_width * rise / length, kLowestPx, kHighestPx);
  // The same scale both ways, but where a long line would be a flat one.
  const double scale_y = plot_height / rise;
  const double scale_x = std::min(plot_width / length, scale_y);
  Svg svg(kWidthPx, plot_height + kTopPx + kBottomPx);
  const auto x = [&](double s) { return kLeftPx + s * scale_x; };
  const auto y = [&](double z) { return kTopPx + (high - z) * scale_y; };
  svg.axes({kLeftPx, kTopPx, length * scale_x, plot_height}, {0.0, length}, {low, low + rise});
  double key_x = kLeftPx + 8.0;
  for (const std::size_t side : {0u, 1u}) {
    std::string path;
    for (const auto& segment : profile.segments[side]) {
      path += svg_move(x(segment[0].along_m), y(segment[0].height_m)) +
              svg_line(x(segment[1].along_m), y(segment[1].height_m));
    }
    for (const ProfilePoint& p : profile.points[side]) {
      path += svg_move(x(p.along_m), y(p.height_m)) + "h.01";
    }
    svg.path(path, kColours[side], profile.points[side].empty() ? 1.4 : 2.0);
    const std::string name = std::string(side == 0 ? "A " : "B ") + names[side];
    svg.key(key_x, 16.0, kColours[side], name);
    key_x += 60.0 + 7.0 * static_cast<double>(name.size());
  }
  char text[96];
  const double exaggeration = scale_y / scale_x;
  std::snprintf(text, sizeof text, "metres along the line; heights %s",
                std::abs(exaggeration - 1.0) < 0.01
                    ? "at the same scale"
                    : (std::to_string(exaggeration).substr(0, 4) + " times").c_str());
  svg.text(kLeftPx + length * scale_x / 2.0, kTopPx + plot_height + 36.0, text, "middle");
  return svg.finish();
}

}  // namespace cornice::compare
