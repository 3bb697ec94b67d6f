// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/orientation/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cornice::bench {
namespace {

constexpr double kRadians = 0.017453292519943295;
constexpr Colour kWrong{220, 30, 30}, kUnsettled{240, 200, 0};

Colour grey(Vec3f normal, Vec3f viewer) {
  const Vec3f light = normalized(viewer + Vec3f{-0.5f, 0.3f, 0.6f});
  const float lit = 0.25f + 0.75f * std::max(dot(normal, light), 0.0f);
  const auto value = static_cast<std::uint8_t>(235.0f * std::min(lit, 1.0f));
  return {static_cast<std::uint8_t>(value * 0.92f), static_cast<std::uint8_t>(value * 0.96f),
          value};
}

}  // namespace

Vec3f towards_viewer(double azimuth_deg, double altitude_deg) {
  const double a = azimuth_deg * kRadians, h = altitude_deg * kRadians;
  return Vec3d{std::sin(a) * std::cos(h), std::cos(a) * std::cos(h), std::sin(h)}.cast<float>();
}

Picture view(std::span<const Vec3f> positions, std::span<const Colour> colours, double azimuth_deg,
             double altitude_deg, int width) {
  const Vec3f to = towards_viewer(azimuth_deg, altitude_deg);
  const Vec3f right = normalized(cross(Vec3f{0, 0, 1}, to));
  const Vec3f up = cross(to, right);
  float low_r = std::numeric_limits<float>::max(), high_r = -low_r, low_u = low_r, high_u = -low_r;
  for (const Vec3f& p : positions) {
    low_r = std::min(low_r, dot(p, right)), high_r = std::max(high_r, dot(p, right));
    low_u = std::min(low_u, dot(p, up)), high_u = std::max(high_u, dot(p, up));
  }
  Picture picture;
  if (positions.empty()) return picture;
  picture.width = width;
  const float scale = static_cast<float>(width - 8) / std::max(high_r - low_r, 1e-3f);
  picture.height = static_cast<int>(scale * (high_u - low_u)) + 8;
  const auto pixels =
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  picture.pixels.assign(pixels, {255, 255, 255});
  std::vector<float> nearest(pixels, -std::numeric_limits<float>::max());
  // A square as wide as the mean distance of points, so that a sheet hides what lies behind it.
  const float area = (high_r - low_r) * (high_u - low_u);
  const float spacing = std::sqrt(area / static_cast<float>(positions.size()));
  const int half = std::clamp(static_cast<int>(1.2f * spacing * scale), 1, 6);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const int x = 4 + static_cast<int>((dot(positions[i], right) - low_r) * scale);
    const int y = picture.height - 4 - static_cast<int>((dot(positions[i], up) - low_u) * scale);
    const float depth = dot(positions[i], to);
    for (int v = std::max(y - half, 0); v <= std::min(y + half, picture.height - 1); ++v) {
      for (int u = std::max(x - half, 0); u <= std::min(x + half, picture.width - 1); ++u) {
        const std::size_t at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(u);
        if (depth <= nearest[at]) continue;
        nearest[at] = depth;
        picture.pixels[at] = colours[i];
      }
    }
  }
  return picture;
}

std::vector<Colour> colour_by_truth(const std::vector<Vec3f>& normals,
                                    const std::vector<std::uint8_t>& settled,
                                    const std::vector<Vec3f>& truth, Vec3f viewer) {
  std::vector<Colour> colours(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const bool right = dot(normals[i], truth[i]) > 0.0f;
    colours[i] = settled[i] == 0 ? kUnsettled : right ? grey(normals[i], viewer) : kWrong;
  }
  return colours;
}

std::vector<Colour> colour_by_facing(const std::vector<Vec3f>& normals, Vec3f viewer) {
  std::vector<Colour> colours(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    colours[i] = dot(normals[i], viewer) > 0.0f ? grey(normals[i], viewer) : kWrong;
  }
  return colours;
}

}  // namespace cornice::bench
