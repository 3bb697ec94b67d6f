// SPDX-License-Identifier: GPL-3.0-or-later
// Splats into a depth buffer; the light is computed from the buffer, so that points need no
// normals.
#include "pipeline/pictures/oblique.h"

#include <cassert>
#include <cmath>
#include <limits>

namespace cornice::pictures {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
/// Of depth between neighbouring pixels, above which they show two surfaces.
constexpr float kStepPx = 12.0f;
constexpr int kHolePasses = 4;

/// Depth along the view in pixels and colour, row by row from the top.
struct Buffer {
  int width = 0;
  int height = 0;
  std::vector<float> depth;
  std::vector<Rgb> colour;

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  float at(int x, int y) const {
    return x < 0 || y < 0 || x >= width || y >= height ? kNothing : depth[index(x, y)];
  }
};

Buffer splat(const ColouredPoints& points, const View& view) {
  const Axes axes = axes_of(view);
  Box3d box;
  for (const Vec3f& p : points.positions) box.add(seen(axes, p));
  const Frame frame = frame_of(view, box);

  Buffer buffer;
  buffer.width = frame.width;
  buffer.height = frame.height;
  buffer.depth.assign(frame.pixels(), kNothing);
  buffer.colour.assign(frame.pixels(), Rgb{});

  // Points spread evenly would lie this far apart; a splat reaches a little beyond its neighbour.
  const double area_px = (frame.width - 2.0 * frame.left_px) * (frame.height - 2.0 * kMarginPx);
  const double spacing_px = std::sqrt(area_px / static_cast<double>(points.positions.size()));
  const int radius = static_cast<int>(std::lround(0.7 * spacing_px));
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const Vec3d p = frame.place(seen(axes, points.positions[i]));
    const int cx = static_cast<int>(p.x), cy = static_cast<int>(p.y);
    const auto depth = static_cast<float>(p.z);
    for (int y = std::max(cy - radius, 0); y <= std::min(cy + radius, buffer.height - 1); ++y) {
      for (int x = std::max(cx - radius, 0); x <= std::min(cx + radius, buffer.width - 1); ++x) {
        const std::size_t at = buffer.index(x, y);
        if (depth >= buffer.depth[at]) continue;
        buffer.depth[at] = depth;
        buffer.colour[at] = points.colours[i];
      }
    }
  }
  return buffer;
}

/// Fills pixels that no point fell on, or only one from far behind, although most of their
/// neighbours show a nearer surface.
void close_holes(Buffer& buffer) {
  const Buffer before = buffer;
  for (int y = 0; y < buffer.height; ++y) {
    for (int x = 0; x < buffer.width; ++x) {
      const float limit = before.at(x, y) - kStepPx;
      int nearer = 0;
      float nearest = kNothing;
      std::size_t from = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const float depth = before.at(x + dx, y + dy);
          if (depth == kNothing || depth >= limit) continue;
          ++nearer;
          if (depth < nearest) nearest = depth, from = before.index(x + dx, y + dy);
        }
      }
      if (nearer < 5) continue;
      buffer.depth[buffer.index(x, y)] = nearest;
      buffer.colour[buffer.index(x, y)] = before.colour[from];
    }
  }
}

/// Mean depth over a window, of what lies on the same surface as its middle.
float smooth_depth(const Buffer& buffer, int x, int y, int reach) {
  const float middle = buffer.at(x, y);
  float sum = 0.0f;
  int count = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const float depth = buffer.at(x + dx, y + dy);
      if (depth == kNothing || std::abs(depth - middle) > kStepPx) continue;
      sum += depth;
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<float>(count) : middle;
}

/// Lambert's law on the buffer's slope, darkened where nearer things stand beside the pixel.
float light_at(const Buffer& buffer, const std::vector<float>& smooth, int x, int y) {
  const float middle = smooth[buffer.index(x, y)];
  const auto slope = [&](int dx, int dy) {
    const bool ahead = buffer.at(x + dx, y + dy) != kNothing;
    const bool behind = buffer.at(x - dx, y - dy) != kNothing;
    const float a = ahead ? smooth[buffer.index(x + dx, y + dy)] : middle;
    const float b = behind ? smooth[buffer.index(x - dx, y - dy)] : middle;
    return (a - b) / (ahead && behind ? 2.0f : 1.0f);
  };
  // Screen axes: x right, y down, z towards the eye.
  const Vec3f normal = normalized(Vec3f{slope(1, 0), slope(0, 1), 1.0f});
  const Vec3f light = normalized(Vec3f{-0.6f, -0.55f, 0.6f});
  const float lambert = std::max(0.0f, dot(normal, light));
  float step = 0.0f;
  for (int k = 0; k < 8; ++k) {
    constexpr int kDx[] = {3, 3, 0, -3, -3, -3, 0, 3};
    constexpr int kDy[] = {0, 3, 3, 3, 0, -3, -3, -3};
    const float depth = buffer.at(x + kDx[k], y + kDy[k]);
    if (depth != kNothing) step += std::max(0.0f, middle - depth - kStepPx);
  }
  return (0.35f + 0.75f * lambert) * std::exp(-0.002f * step);
}

/// The buffer under its light, at full resolution.
Picture lit(const Buffer& buffer) {
  std::vector<float> smooth(buffer.depth.size(), kNothing);
  for (int y = 0; y < buffer.height; ++y) {
    for (int x = 0; x < buffer.width; ++x) {
      if (buffer.at(x, y) != kNothing) smooth[buffer.index(x, y)] = smooth_depth(buffer, x, y, 2);
    }
  }
  Picture picture{buffer.width, buffer.height, {}};
  picture.pixels.assign(buffer.depth.size(), Rgb{255, 255, 255});
  for (int y = 0; y < buffer.height; ++y) {
    for (int x = 0; x < buffer.width; ++x) {
      const std::size_t at = buffer.index(x, y);
      if (buffer.depth[at] == kNothing) continue;
      picture.pixels[at] = shaded(buffer.colour[at], light_at(buffer, smooth, x, y));
    }
  }
  return picture;
}

}  // namespace

Picture oblique_picture(const ColouredPoints& points, const View& view) {
  assert(!points.positions.empty());
  Buffer buffer = splat(points, view);
  for (int pass = 0; pass < kHolePasses; ++pass) close_holes(buffer);
  return reduced(lit(buffer));
}

}  // namespace cornice::pictures
