// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/scale_bar.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace cornice::viewer {
namespace {

constexpr float kMargin = 24.0f;  ///< from the picture's right and lower edges
constexpr float kGap = 12.0f;     ///< from what else is there

double round_length(double most_m) {
  const double power = std::pow(10.0, std::floor(std::log10(most_m)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= most_m) return factor * power;
  return power;
}

}  // namespace

ScaleBar scale_bar(const Camera& camera, int height, double depth_m, double most_pixels) {
  const double half = 0.5 * camera.field_of_view_deg * std::numbers::pi / 180.0;
  const double per_pixel = 2.0 * depth_m * std::tan(half) / height;
  ScaleBar bar;
  bar.length_m = round_length(per_pixel * most_pixels);
  bar.pixels = bar.length_m / per_pixel;
  std::array<char, 48> text{};
  if (bar.length_m >= 1000.0)
    std::snprintf(text.data(), text.size(), "%g km", bar.length_m / 1000.0);
  else
    std::snprintf(text.data(), text.size(), "%g m", bar.length_m);
  bar.label = text.data();
  return bar;
}

ScalePlace scale_place(int width, int height, float wide, float taken_right, float taken_top) {
  const float right = float(width) - kMargin, low = float(height) - kMargin;
  if (right - wide >= taken_right + kGap) return {right, low};
  return {right, taken_top - kGap};
}

}  // namespace cornice::viewer
