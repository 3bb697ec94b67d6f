// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_canopy.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cornice::simulate {
namespace {

struct Span {
  double enter, exit;
  std::uint32_t tree;
};

/// Spans of the crowns met so far; more than fit are dropped, which only dense overlap can cause.
struct Spans {
  std::array<Span, 24> items;
  std::size_t count = 0;

  bool has(std::uint32_t tree) const {
    for (std::size_t i = 0; i < count; ++i) {
      if (items[i].tree == tree) return true;
    }
    return false;
  }
};

bool cross_crown(const Tree& tree, const Ray& ray, Span& span) {
  const double ir = 1.0 / static_cast<double>(tree.radius);
  const double ih = 1.0 / static_cast<double>(tree.half_height);
  const Vec3d o = ray.origin - tree.middle.cast<double>();
  const Vec3d p{o.x * ir, o.y * ir, o.z * ih};
  const Vec3d d{ray.direction.x * ir, ray.direction.y * ir, ray.direction.z * ih};
  const double a = dot(d, d), b = dot(p, d);
  // The point of the line nearest to the middle, so that far origins lose no digits.
  const Vec3d nearest = p - d * (b / a);
  const double left = 1.0 - dot(nearest, nearest);
  if (left <= 0.0) return false;
  const double half = std::sqrt(left / a);
  span.enter = -b / a - half;
  span.exit = -b / a + half;
  return true;
}

}  // namespace

Canopy::Canopy(std::vector<Tree> trees, const Box2d& area, double returns_per_m)
    : trees_(std::move(trees)), area_(area.grown(8.0)), returns_per_m_(returns_per_m) {
  if (trees_.empty()) return;
  columns_ = static_cast<int>(area_.width() / kCell) + 1;
  rows_ = static_cast<int>(area_.height() / kCell) + 1;
  cells_.resize(static_cast<std::size_t>(columns_) * rows_);
  const auto visit = [&](auto&& put) {
    for (std::uint32_t n = 0; n < trees_.size(); ++n) {
      const Tree& tree = trees_[n];
      const double r = static_cast<double>(tree.radius);
      const double x = static_cast<double>(tree.middle.x) - area_.min_x;
      const double y = static_cast<double>(tree.middle.y) - area_.min_y;
      const auto cell = [](double v, int most) {
        return std::clamp(static_cast<int>(v / kCell), 0, most - 1);
      };
      for (int j = cell(y - r, rows_); j <= cell(y + r, rows_); ++j) {
        for (int i = cell(x - r, columns_); i <= cell(x + r, columns_); ++i) {
          put(cells_[static_cast<std::size_t>(j) * columns_ + i], n, tree);
        }
      }
    }
  };
  bottom_ = 1e30, top_ = -1e30;
  visit([&](Cell& cell, std::uint32_t, const Tree& tree) {
    const float low = tree.middle.z - tree.half_height, high = tree.middle.z + tree.half_height;
    cell.bottom = cell.count == 0 ? low : std::min(cell.bottom, low);
    cell.top = cell.count == 0 ? high : std::max(cell.top, high);
    ++cell.count;
    bottom_ = std::min(bottom_, static_cast<double>(low));
    top_ = std::max(top_, static_cast<double>(high));
  });
  std::uint32_t first = 0;
  for (Cell& cell : cells_) {
    cell.first = first;
    first += cell.count;
    cell.count = 0;
  }
  listed_.resize(first);
  visit([&](Cell& cell, std::uint32_t n, const Tree&) { listed_[cell.first + cell.count++] = n; });
}

bool Canopy::passage(const Ray& ray, double max_m, CanopyPassage& passage) const {
  if (trees_.empty()) return false;
  // The part of the ray that can meet a crown.
  double begin = 0.0, end = max_m;
  const auto clip = [&](double origin, double direction, double low, double high) {
    if (direction == 0.0) {
      if (origin < low || origin > high) end = -1.0;
      return;
    }
    const double a = (low - origin) / direction, b = (high - origin) / direction;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  };
  clip(ray.origin.z, ray.direction.z, bottom_, top_);
  clip(ray.origin.x, ray.direction.x, area_.min_x, area_.max_x);
  clip(ray.origin.y, ray.direction.y, area_.min_y, area_.max_y);
  if (begin >= end) return false;

  const auto place = [&](double t, double origin, double direction, double low, int most) {
    return std::clamp(static_cast<int>((origin + t * direction - low) / kCell), 0, most - 1);
  };
  int i = place(begin, ray.origin.x, ray.direction.x, area_.min_x, columns_);
  int j = place(begin, ray.origin.y, ray.direction.y, area_.min_y, rows_);
  const int step_i = ray.direction.x > 0.0 ? 1 : -1, step_j = ray.direction.y > 0.0 ? 1 : -1;
  const auto border = [&](int cell, double origin, double direction, double low) {
    if (direction == 0.0) return 1e30;
    return (low + (cell + (direction > 0.0 ? 1 : 0)) * kCell - origin) / direction;
  };
  double next_i = border(i, ray.origin.x, ray.direction.x, area_.min_x);
  double next_j = border(j, ray.origin.y, ray.direction.y, area_.min_y);
  const double width_i = kCell / std::max(std::abs(ray.direction.x), 1e-30);
  const double width_j = kCell / std::max(std::abs(ray.direction.y), 1e-30);

  Spans spans;
  double at = begin;
  while (at < end) {
    const double leave = std::min({next_i, next_j, end});
    const Cell& cell = cells_[static_cast<std::size_t>(j) * columns_ + i];
    const double za = ray.origin.z + at * ray.direction.z;
    const double zb = ray.origin.z + leave * ray.direction.z;
    if (cell.count > 0 && std::min(za, zb) < static_cast<double>(cell.top) &&
        std::max(za, zb) > static_cast<double>(cell.bottom)) {
      for (std::uint32_t n = cell.first; n < cell.first + cell.count; ++n) {
        Span span{};
        span.tree = listed_[n];
        if (!cross_crown(trees_[span.tree], ray, span) || span.enter >= max_m || span.exit <= 0.0 ||
            spans.has(span.tree)) {
          continue;
        }
        if (spans.count < spans.items.size()) spans.items[spans.count++] = span;
      }
    }
    if (leave >= end) break;
    at = leave;
    if (next_i <= next_j) {
      i += step_i;
      next_i += width_i;
      if (i < 0 || i >= columns_) break;
    } else {
      j += step_j;
      next_j += width_j;
      if (j < 0 || j >= rows_) break;
    }
  }
  if (spans.count == 0) return false;
  std::sort(spans.items.begin(), spans.items.begin() + static_cast<std::ptrdiff_t>(spans.count),
            [](const Span& a, const Span& b) {
              return a.enter != b.enter ? a.enter < b.enter : a.tree < b.tree;
            });
  constexpr double kGap = 2.0;
  double leaves = 0.0;
  passage.enter_m = std::max(spans.items[0].enter, 0.0);
  passage.exit_m = passage.enter_m;
  for (std::size_t n = 0; n < spans.count; ++n) {
    const double enter = std::max(spans.items[n].enter, 0.0);
    const double exit = std::min(spans.items[n].exit, max_m);
    if (n > 0 && enter > passage.exit_m + kGap) break;
    leaves += std::max(exit - enter, 0.0);
    passage.exit_m = std::max(passage.exit_m, exit);
  }
  const double length = passage.exit_m - passage.enter_m;
  if (length <= 0.0) return false;
  passage.density = returns_per_m_ * leaves / length;
  return true;
}

}  // namespace cornice::simulate
