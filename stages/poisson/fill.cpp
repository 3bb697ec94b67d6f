// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/fill.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace cornice::poisson {
namespace {

/// Squares to a distance `beyond`: a place is off by at most a square's diagonal, an eighth of it.
constexpr double kSquaresPerDistance = 12.0;

/// Which squares of a grid, the same for all tiles, hold a point.
class Cover {
 public:
  Cover(const Box2d& area, double beyond_m)
      : side_(beyond_m / kSquaresPerDistance),
        first_x_(index(area.min_x - beyond_m)),
        first_y_(index(area.min_y - beyond_m)),
        width_(index(area.max_x + beyond_m) + 1 - first_x_),
        height_(index(area.max_y + beyond_m) + 1 - first_y_),
        taken_(static_cast<std::size_t>(width_ * height_), 0) {
    const auto reach = static_cast<std::int64_t>(kSquaresPerDistance);
    for (std::int64_t y = -reach; y <= reach; ++y) {
      for (std::int64_t x = -reach; x <= reach; ++x) {
        if (x * x + y * y <= reach * reach) disc_.push_back({x, y});
      }
    }
    // Nearest first: where there are points, the first look finds one.
    std::sort(disc_.begin(), disc_.end(),
              [](Square a, Square b) { return a.x * a.x + a.y * a.y < b.x * b.x + b.y * b.y; });
  }

  void add(double x, double y) {
    const std::int64_t i = index(x) - first_x_, j = index(y) - first_y_;
    if (is_inside(i, j)) taken_[static_cast<std::size_t>(j * width_ + i)] = 1;
  }

  bool is_gap(double x, double y) const {
    const std::int64_t i = index(x) - first_x_, j = index(y) - first_y_;
    return std::none_of(disc_.begin(), disc_.end(), [&](Square s) {
      return is_inside(i + s.x, j + s.y) &&
             taken_[static_cast<std::size_t>((j + s.y) * width_ + i + s.x)] != 0;
    });
  }

 private:
  struct Square {
    std::int64_t x, y;
  };
  std::int64_t index(double at) const { return static_cast<std::int64_t>(std::floor(at / side_)); }
  bool is_inside(std::int64_t i, std::int64_t j) const {
    return i >= 0 && j >= 0 && i < width_ && j < height_;
  }

  double side_;
  std::int64_t first_x_, first_y_, width_, height_;
  std::vector<std::uint8_t> taken_;
  std::vector<Square> disc_;
};

void add_point(OrientedPoints& points, Vec3d at, Vec3d normal, float quality) {
  points.positions.push_back((at - points.origin).cast<float>());
  points.normals.push_back(normal.cast<float>());
  points.quality.push_back(quality);
}

}  // namespace

std::uint64_t fill_gaps(OrientedPoints& points, const ElevationModel& model, const Box2d& area,
                        const FillOptions& options) {
  if (model.empty() || area.empty()) return 0;
  Cover cover(area, options.beyond_m);
  for (const Vec3f p : points.positions) {
    const Vec3d at = points.origin + p.cast<double>();
    if (std::isfinite(at.x) && std::isfinite(at.y)) cover.add(at.x, at.y);
  }
  if (points.quality.empty()) points.quality.assign(points.positions.size(), 1.0f);
  const std::size_t before = points.positions.size();
  const double spacing = std::clamp(model.finest_step_m(), options.step_m, 2.0 * options.step_m);
  const auto first = [&](double at) { return std::ceil(at / spacing - 0.5); };
  for (double row = first(area.min_y); (row + 0.5) * spacing <= area.max_y; ++row) {
    for (double col = first(area.min_x); (col + 0.5) * spacing <= area.max_x; ++col) {
      const double x = (col + 0.5) * spacing, y = (row + 0.5) * spacing;
      if (!cover.is_gap(x, y)) continue;
      const auto ground = model.at(x, y);
      if (ground) add_point(points, {x, y, ground->height_m}, ground->normal, options.quality);
    }
  }
  const std::size_t count = points.positions.size();
  for (FloatProperty& p : points.float_properties) p.values.resize(count, 0.0f);
  for (ByteProperty& p : points.byte_properties) p.values.resize(count, 0);
  if (!points.line_id.empty()) points.line_id.resize(count, 0);
  return count - before;
}

}  // namespace cornice::poisson
