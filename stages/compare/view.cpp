// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cornice::compare {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr int kTallestPx = 1600;
const Vec3f kSun = normalized(Vec3f{-0.5f, 0.5f, 0.7071f});
const Vec3f kFill = normalized(Vec3f{0.3f, -0.9f, 0.3f});

/// The sun from the north-west, and a weak light across so that walls in the shade keep their form.
double light_on(Vec3f normal) {
  const Vec3f n = normalized(normal);
  return 0.45 + 0.06 * static_cast<double>(n.z) +
         0.5 * static_cast<double>(std::max(0.0f, dot(n, kSun))) +
         0.22 * static_cast<double>(std::max(0.0f, dot(n, kFill)));
}

}  // namespace

View::View(const ViewPlan& plan) {
  const double h = plan.heading_deg * kRadians, t = plan.tilt_deg * kRadians;
  right_ = {std::cos(h), -std::sin(h), 0.0};
  up_ = {std::sin(h) * std::sin(t), std::cos(h) * std::sin(t), std::cos(t)};
  forward_ = {std::sin(h) * std::cos(t), std::cos(h) * std::cos(t), -std::sin(t)};
  double low_x = 1e300, high_x = -1e300, low_y = 1e300, high_y = -1e300;
  for (int k = 0; k < 8; ++k) {
    const Vec3d p{k & 1 ? plan.box.max.x : plan.box.min.x, k & 2 ? plan.box.max.y : plan.box.min.y,
                  k & 4 ? plan.box.max.z : plan.box.min.z};
    low_x = std::min(low_x, dot(p, right_)), high_x = std::max(high_x, dot(p, right_));
    low_y = std::min(low_y, dot(p, up_)), high_y = std::max(high_y, dot(p, up_));
  }
  px_per_m_ = std::min(kFiner * plan.width_px / std::max(high_x - low_x, 1e-3),
                       kFiner * kTallestPx / std::max(high_y - low_y, 1e-3));
  width_ = kFiner * std::max(1, static_cast<int>((high_x - low_x) * px_per_m_) / kFiner);
  height_ = kFiner * std::max(1, static_cast<int>((high_y - low_y) * px_per_m_) / kFiner);
  low_x_ = low_x, high_y_ = high_y;
  const auto count = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  depth_.assign(count, std::numeric_limits<float>::infinity());
  pixels_.assign(count, {255, 255, 255});
}

View::Corner View::corner(const Surface& surface, std::uint32_t vertex, Rgb colour) const {
  const Vec3d p = surface.origin + surface.positions[vertex].cast<double>();
  return {{(dot(p, right_) - low_x_) * px_per_m_, (high_y_ - dot(p, up_)) * px_per_m_,
           dot(p, forward_)},
          surface.normals.empty() ? Vec3f{0, 0, 1} : surface.normals[vertex],
          colour};
}

void View::put(int x, int y, double depth, const std::array<double, 3>& colour, Vec3f normal) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  const std::size_t at =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  // Relative to the frame's depth a float is fine enough.
  const auto d = static_cast<float>(depth);
  if (!(d < depth_[at])) return;
  depth_[at] = d;
  const double light = light_on(normal);
  for (std::size_t k = 0; k < 3; ++k) {
    pixels_[at][k] =
        static_cast<std::uint8_t>(std::lround(std::clamp(light * colour[k], 0.0, 255.0)));
  }
}

void View::fill(const std::array<Corner, 3>& c) {
  const Vec3d &a = c[0].at, &b = c[1].at, &d = c[2].at;
  const double area = (b.x - a.x) * (d.y - a.y) - (d.x - a.x) * (b.y - a.y);
  if (area == 0.0) return;
  const auto [low_x, high_x] = std::minmax({a.x, b.x, d.x});
  const auto [low_y, high_y] = std::minmax({a.y, b.y, d.y});
  const int x0 = std::max(0, static_cast<int>(std::floor(low_x - 0.5)));
  const int x1 = std::min(width_ - 1, static_cast<int>(std::ceil(high_x)));
  const int y0 = std::max(0, static_cast<int>(std::floor(low_y - 0.5)));
  const int y1 = std::min(height_ - 1, static_cast<int>(std::ceil(high_y)));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
      const double wb = (px * (d.y - a.y) - (d.x - a.x) * py) / area;
      const double wd = ((b.x - a.x) * py - px * (b.y - a.y)) / area;
      const double wa = 1.0 - wb - wd;
      if (wa < -1e-9 || wb < -1e-9 || wd < -1e-9) continue;
      std::array<double, 3> colour;
      for (std::size_t k = 0; k < 3; ++k) {
        colour[k] = wa * c[0].colour[k] + wb * c[1].colour[k] + wd * c[2].colour[k];
      }
      const Vec3f normal = c[0].normal * static_cast<float>(wa) +
                           c[1].normal * static_cast<float>(wb) +
                           c[2].normal * static_cast<float>(wd);
      put(x, y, wa * a.z + wb * b.z + wd * d.z, colour, normal);
    }
  }
}

void View::dot_at(const Corner& c) {
  const std::array<double, 3> colour{static_cast<double>(c.colour[0]),
                                     static_cast<double>(c.colour[1]),
                                     static_cast<double>(c.colour[2])};
  const int x = static_cast<int>(std::floor(c.at.x)), y = static_cast<int>(std::floor(c.at.y));
  for (int k = 0; k < kFiner * kFiner; ++k) {
    put(x + k % kFiner, y + k / kFiner, c.at.z, colour, c.normal);
  }
}

void View::add(const Surface& surface, const std::vector<Rgb>& colours,
               const std::vector<std::uint8_t>& marked, Rgb mark) {
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const bool is_marked = !marked.empty() && marked[t] != 0;
    std::array<Corner, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = surface.triangles[t][k];
      corners[k] = corner(surface, v, is_marked ? mark : colours[v]);
    }
    fill(corners);
  }
  if (!surface.triangles.empty()) return;
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
    dot_at(corner(surface, v, colours[v]));
  }
}

Picture View::picture() const {
  Picture picture{width_ / kFiner, height_ / kFiner, {}};
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      std::array<int, 3> sum{};
      for (int k = 0; k < kFiner * kFiner; ++k) {
        const auto row = static_cast<std::size_t>(kFiner * y + k / kFiner);
        const Rgb& pixel = pixels_[row * static_cast<std::size_t>(width_) +
                                   static_cast<std::size_t>(kFiner * x + k % kFiner)];
        for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
      }
      Rgb mean{};
      for (std::size_t c = 0; c < 3; ++c) {
        mean[c] = static_cast<std::uint8_t>(sum[c] / (kFiner * kFiner));
      }
      picture.pixels.push_back(mean);
    }
  }
  return picture;
}

}  // namespace cornice::compare
