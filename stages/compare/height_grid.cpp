// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/height_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cornice::compare {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoData = -9999.0f;
/// Parts of a triangle by which a pixel's centre may lie outside and still be on its edge.
constexpr double kOnEdge = 1e-9;

Raster raster_of(const GridFrame& frame, const Crs& crs) {
  Raster raster;
  raster.width = frame.width;
  raster.height = frame.height;
  raster.west = frame.west;
  raster.north = frame.north;
  raster.step = frame.step;
  raster.no_data = kNoData;
  raster.crs = crs;
  raster.values.assign(frame.pixels(), kNoData);
  return raster;
}

}  // namespace

GridFrame frame_over(const Box2d& box, double step, double west, double north) {
  GridFrame frame;
  frame.step = step;
  frame.west = west + std::floor((box.min_x - west) / step + 1e-6) * step;
  frame.north = north + std::ceil((box.max_y - north) / step - 1e-6) * step;
  frame.width = std::max(1, static_cast<int>(std::ceil((box.max_x - frame.west) / step - 1e-6)));
  frame.height = std::max(1, static_cast<int>(std::ceil((frame.north - box.min_y) / step - 1e-6)));
  return frame;
}

HeightGrid::HeightGrid(const GridFrame& frame)
    : frame_(frame), top_(frame.pixels(), kNothing), bottom_(frame.pixels(), kNothing) {}

void HeightGrid::add(const Surface& surface) {
  if (surface.triangles.empty()) return add_points(surface);
  for (const Triangle& triangle : surface.triangles) add_triangle(surface, triangle);
}

void HeightGrid::add_triangle(const Surface& surface, const Triangle& triangle) {
  Vec3d corner[3];
  double low_x = 1e300, high_x = -1e300, low_y = 1e300, high_y = -1e300;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d p = surface.origin + surface.positions[triangle[k]].cast<double>();
    // Pixel centres are whole numbers here; y down.
    corner[k] = {(p.x - frame_.west) / frame_.step - 0.5, (frame_.north - p.y) / frame_.step - 0.5,
                 p.z};
    low_x = std::min(low_x, corner[k].x), high_x = std::max(high_x, corner[k].x);
    low_y = std::min(low_y, corner[k].y), high_y = std::max(high_y, corner[k].y);
  }
  const int col0 = static_cast<int>(std::max(0.0, std::ceil(low_x - 1e-6)));
  const int col1 = static_cast<int>(std::min(frame_.width - 1.0, std::floor(high_x + 1e-6)));
  const int row0 = static_cast<int>(std::max(0.0, std::ceil(low_y - 1e-6)));
  const int row1 = static_cast<int>(std::min(frame_.height - 1.0, std::floor(high_y + 1e-6)));
  const Vec3d ab = corner[1] - corner[0], ac = corner[2] - corner[0];
  const double area = ab.x * ac.y - ab.y * ac.x;
  // y points down here, so that what looks up runs clockwise.
  if (!(area < 0.0)) return;
  // A centre on an edge belongs to both sides, but for rounding: a little is let through, so that
  // no centre falls between two triangles.
  const double reach = kOnEdge + 1e-6 * std::max(high_x - low_x, high_y - low_y) / -area;
  for (int row = row0; row <= row1; ++row) {
    for (int col = col0; col <= col1; ++col) {
      const double x = col - corner[0].x, y = row - corner[0].y;
      const double u = (x * ac.y - y * ac.x) / area, v = (ab.x * y - ab.y * x) / area;
      if (u < -reach || v < -reach || u + v > 1.0 + reach) continue;
      const auto z = static_cast<float>(corner[0].z + u * ab.z + v * ac.z);
      const std::size_t at =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(frame_.width) +
          static_cast<std::size_t>(col);
      if (!(top_[at] >= z)) top_[at] = z;
      if (!(bottom_[at] <= z)) bottom_[at] = z;
    }
  }
}

void HeightGrid::add_points(const Surface& surface) {
  if (sum_.empty()) {
    sum_.assign(frame_.pixels(), 0.0f);
    count_.assign(frame_.pixels(), 0);
  }
  for (const Vec3f& position : surface.positions) {
    const Vec3d p = surface.origin + position.cast<double>();
    const double col = std::floor((p.x - frame_.west) / frame_.step);
    const double row = std::floor((frame_.north - p.y) / frame_.step);
    if (col < 0.0 || row < 0.0 || col >= frame_.width || row >= frame_.height) continue;
    const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(frame_.width) +
                           static_cast<std::size_t>(col);
    if (count_[at] == 0) top_[at] = bottom_[at] = static_cast<float>(p.z);
    sum_[at] += static_cast<float>(p.z - static_cast<double>(top_[at]));
    ++count_[at];
  }
}

void HeightGrid::finish() {
  for (std::size_t i = 0; i < count_.size(); ++i) {
    if (count_[i] == 0) continue;
    top_[i] += sum_[i] / static_cast<float>(count_[i]);
    bottom_[i] = top_[i];
  }
  std::vector<float>().swap(sum_);
  std::vector<std::uint32_t>().swap(count_);
}

std::uint64_t HeightGrid::filled() const {
  return static_cast<std::uint64_t>(
      std::count_if(top_.begin(), top_.end(), [](float z) { return !std::isnan(z); }));
}

Place place_on_grid(const HeightGrid& heights, std::size_t pixel, bool overhang) {
  const GridFrame& frame = heights.frame();
  const auto width = static_cast<std::size_t>(frame.width);
  const std::size_t col = pixel % width, row = pixel / width;
  const Place flat = place_of({0, 0, 1}, 0.0f, overhang);
  if (col == 0 || row == 0 || col + 1 == width ||
      row + 1 == static_cast<std::size_t>(frame.height)) {
    return flat;
  }
  double z[3][3];
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      z[j][i] = static_cast<double>(heights.top(pixel + (j * width + i) - width - 1));
      if (std::isnan(z[j][i])) return flat;
    }
  }
  const double step = frame.step;
  const double east =
      (z[0][2] + 2 * z[1][2] + z[2][2] - z[0][0] - 2 * z[1][0] - z[2][0]) / (8 * step);
  const double north =
      (z[0][0] + 2 * z[0][1] + z[0][2] - z[2][0] - 2 * z[2][1] - z[2][2]) / (8 * step);
  const double laplacian = (z[0][1] + z[2][1] + z[1][0] + z[1][2] - 4 * z[1][1]) / (step * step);
  const Vec3d normal = normalized(Vec3d{-east, -north, 1.0});
  return place_of(normal.cast<float>(),
                  static_cast<float>(-0.5 * laplacian * normal.z * normal.z * normal.z), overhang);
}

Raster difference(const HeightGrid& a, const HeightGrid& b, const Crs& crs) {
  Raster raster = raster_of(a.frame(), crs);
  for (std::size_t i = 0; i < raster.values.size(); ++i) {
    const float value = b.top(i) - a.top(i);
    if (!std::isnan(value)) raster.values[i] = value;
  }
  return raster;
}

Raster heights_of(const HeightGrid& heights, const Crs& crs) {
  Raster raster = raster_of(heights.frame(), crs);
  for (std::size_t i = 0; i < raster.values.size(); ++i) {
    if (!std::isnan(heights.top(i))) raster.values[i] = heights.top(i);
  }
  return raster;
}

Raster layer_gaps(const HeightGrid& heights, const Crs& crs) {
  Raster raster = raster_of(heights.frame(), crs);
  for (std::size_t i = 0; i < raster.values.size(); ++i) {
    if (!std::isnan(heights.top(i))) raster.values[i] = heights.gap(i);
  }
  return raster;
}

}  // namespace cornice::compare
