// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/pictures/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cornice::pictures {

Axes axes_of(const View& view) {
  const double h = view.heading_deg * std::numbers::pi / 180.0;
  const double t = view.tilt_deg * std::numbers::pi / 180.0;
  return {{std::cos(h), -std::sin(h), 0.0},
          {std::sin(h) * std::sin(t), std::cos(h) * std::sin(t), std::cos(t)},
          {std::sin(h) * std::cos(t), std::cos(h) * std::cos(t), -std::sin(t)}};
}

Vec3d seen(const Axes& axes, Vec3f position) {
  const Vec3d q = position.cast<double>();
  return {dot(axes.right, q), dot(axes.up, q), dot(axes.forward, q)};
}

Frame frame_of(const View& view, const Box3d& box) {
  const double width_m = std::max(box.max.x - box.min.x, 1e-3);
  const double height_m = std::max(box.max.y - box.min.y, 1e-3);
  Frame frame;
  frame.box = box;
  frame.width = kFiner * view.width_px;
  const double inner = frame.width - 2.0 * kMarginPx;
  const double most_height = kMostHeight * frame.width - 2.0 * kMarginPx;
  frame.px_per_m = std::min(inner / width_m, most_height / height_m);
  frame.left_px = kMarginPx + 0.5 * (inner - width_m * frame.px_per_m);
  frame.height = static_cast<int>(std::ceil(height_m * frame.px_per_m)) + 2 * kMarginPx;
  frame.height += frame.height % kFiner;
  return frame;
}

Picture reduced(const Picture& fine) {
  Picture picture{fine.width / kFiner, fine.height / kFiner, {}};
  picture.pixels.reserve(static_cast<std::size_t>(picture.width) * picture.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      std::array<int, 3> sum{};
      for (int k = 0; k < kFiner * kFiner; ++k) {
        const int fine_y = kFiner * y + k / kFiner;
        const int fine_x = kFiner * x + k % kFiner;
        const auto& pixel = fine.pixels[static_cast<std::size_t>(fine_y) * fine.width + fine_x];
        for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
      }
      std::array<std::uint8_t, 3> mean{};
      for (std::size_t c = 0; c < 3; ++c) {
        mean[c] = static_cast<std::uint8_t>(sum[c] / (kFiner * kFiner));
      }
      picture.pixels.push_back(mean);
    }
  }
  return picture;
}

}  // namespace cornice::pictures
