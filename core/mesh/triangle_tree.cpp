// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/base/parallel.h"

namespace cornice {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 16;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr std::uint32_t kNone = 0xffffffffu;
/// Distances of boxes are rounded to floats; boxes this much farther than the best are opened too.
constexpr float kBoxMargin = 1.0f + 1e-6f;
/// The same distance of one triangle, taken one at a time and in lanes.
constexpr double kGuessMargin = 1.0 + 1e-5;
/// Below this share of its sides' squares, a triangle's squared double area is taken from cross
/// products, which keep twice the digits; below the second, it has none and its edges are all.
constexpr double kThin = 1e-6, kFlat = 1e-15;
/// Nodes and leaves by level and number in one word.
constexpr int kNumberBits = 28;
constexpr std::size_t kMostLevels = 11;

double share(double x, double y) { return std::min(std::max(x / (x + y), 0.0), 1.0); }

/// Inside of a triangle a thousand times as long as wide.
TrianglePlace place_inside_thin(Vec3d ap, Vec3d ab, Vec3d ac) {
  TrianglePlace best;
  const auto try_place = [&](double u, double v) {
    const Vec3d off = ap - ab * u - ac * v;
    const TrianglePlace here{u, v, dot(off, off)};
    if (here.distance_sq < best.distance_sq) best = here;
  };
  best.distance_sq = dot(ap, ap);
  const Vec3d bp = ap - ab, bc = ac - ab;
  const double bb = dot(ab, ab), cc = dot(ac, ac), ee = dot(bc, bc);
  if (bb > 0.0) try_place(std::clamp(dot(ab, ap) / bb, 0.0, 1.0), 0.0);
  if (cc > 0.0) try_place(0.0, std::clamp(dot(ac, ap) / cc, 0.0, 1.0));
  if (ee > 0.0) {
    const double w = std::clamp(dot(bc, bp) / ee, 0.0, 1.0);
    try_place(1.0 - w, w);
  }
  const Vec3d normal = cross(ab, ac);
  const double area = dot(normal, normal);
  const double area_u = dot(normal, cross(ap, ac)), area_v = dot(normal, cross(ab, ap));
  if (area > kFlat * bb * cc && area_u > 0.0 && area_v > 0.0 && area_u + area_v < area) {
    try_place(area_u / area, area_v / area);
  }
  return best;
}

}  // namespace

TrianglePlace nearest_place(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const auto at = [&](double u, double v) {
    const Vec3d d = ap - ab * u - ac * v;
    return TrianglePlace{u, v, dot(d, d)};
  };
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return at(0.0, 0.0);
  const Vec3d bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return at(1.0, 0.0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return at(share(d1, -d3), 0.0);
  const Vec3d cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return at(0.0, 1.0);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return at(0.0, share(d2, -d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = share(d4 - d3, d5 - d6);
    return at(1.0 - w, w);
  }
  const double sum = va + vb + vc;
  // d1 - d3 and d2 - d6 are the squares of the sides.
  if (!(sum > kThin * (d1 - d3) * (d2 - d6))) return place_inside_thin(ap, ab, ac);
  return at(vb / sum, vc / sum);
}

NearestPoint nearest_on_triangle(Vec3f p, Vec3f a, Vec3f b, Vec3f c) {
  const TrianglePlace place =
      nearest_place(p.cast<double>(), a.cast<double>(), b.cast<double>(), c.cast<double>());
  NearestPoint nearest;
  nearest.distance_sq = static_cast<float>(place.distance_sq);
  nearest.u = static_cast<float>(place.u);
  nearest.v = static_cast<float>(place.v);
  return nearest;
}

TriangleTree::TriangleTree(const std::vector<Vec3f>& positions,
                           const std::vector<Triangle>& triangles, int threads)
    : positions_(positions), triangles_(triangles) {
  if (triangles_.empty()) return;
  sort_triangles(threads);
  fill_leaves(threads);
  build_levels(threads);
}

namespace {

struct Item {
  std::array<float, 3> centre;  ///< three times it
  std::uint32_t triangle;
};

struct Range {
  std::size_t begin, end;
};

/// Parts a range along its longest side; the first part fills whole nodes. Returns its end.
std::size_t part(std::vector<Item>& items, Range range) {
  std::size_t half = kLanes;
  while (2 * half < range.end - range.begin) half *= 2;
  std::array<float, 3> low = items[range.begin].centre, high = low;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], items[i].centre[k]);
      high[k] = std::max(high[k], items[i].centre[k]);
    }
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  }
  const auto at = [&](std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(range.begin), at(range.begin + half), at(range.end),
                   [axis](const Item& a, const Item& b) {
                     if (a.centre[axis] != b.centre[axis]) return a.centre[axis] < b.centre[axis];
                     return a.triangle < b.triangle;
                   });
  return range.begin + half;
}

}  // namespace

void TriangleTree::sort_triangles(int threads) {
  std::vector<Item> items(triangles_.size());
  parallel_for(items.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Triangle& c = triangles_[t];
      const Vec3f sum = positions_[c[0]] + positions_[c[1]] + positions_[c[2]];
      items[t] = {{sum.x, sum.y, sum.z}, static_cast<std::uint32_t>(t)};
    }
  });
  std::vector<Range> ranges{{0, items.size()}};
  while (!ranges.empty()) {
    std::vector<Range> parts(2 * ranges.size());
    const std::size_t grain = 1 + kGrain * ranges.size() / items.size();
    parallel_for(ranges.size(), grain, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t r = begin; r < end; ++r) {
        const Range range = ranges[r];
        const std::size_t middle =
            range.end - range.begin > kLanes ? part(items, range) : range.end;
        parts[2 * r] = {range.begin, middle};
        parts[2 * r + 1] = {middle, range.end};
      }
    });
    ranges.clear();
    for (const Range& range : parts) {
      if (range.end - range.begin > kLanes) ranges.push_back(range);
    }
  }
  order_.resize(items.size());
  parallel_for(items.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) order_[i] = items[i].triangle;
    // Within a leaf nothing else decides on the order.
    for (std::size_t i = begin; i < end; i += kLanes) {
      std::sort(order_.begin() + static_cast<std::ptrdiff_t>(i),
                order_.begin() + static_cast<std::ptrdiff_t>(std::min(i + kLanes, end)));
    }
  });
}

/// The last triangle fills what is left of its leaf.
void TriangleTree::fill_leaves(int threads) {
  leaves_.resize((order_.size() + kLanes - 1) / kLanes);
  parallel_for(leaves_.size(), kGrain / kLanes, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end; ++leaf) {
      for (std::size_t k = 0; k < kLanes; ++k) {
        const std::size_t at = std::min(leaf * kLanes + k, order_.size() - 1);
        for (std::size_t corner = 0; corner < 3; ++corner) {
          const Vec3f p = positions_[triangles_[order_[at]][corner]];
          auto& to = leaves_[leaf].corner[corner];
          to[0][k] = p.x, to[1][k] = p.y, to[2][k] = p.z;
        }
      }
    }
  });
}

void TriangleTree::build_levels(int threads) {
  BoxLanes none;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::fill(std::begin(none.low[axis]), std::end(none.low[axis]), kInfinity);
    std::fill(std::begin(none.high[axis]), std::end(none.high[axis]), -kInfinity);
  }
  const auto add_level = [&](std::size_t below) -> std::vector<BoxLanes>& {
    return levels_.emplace_back((below + kLanes - 1) / kLanes, none);
  };
  std::vector<BoxLanes>& lowest = add_level(leaves_.size());
  parallel_for(leaves_.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end; ++leaf) {
      BoxLanes& node = lowest[leaf / kLanes];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float low = kInfinity, high = -kInfinity;
        for (const auto& corner : leaves_[leaf].corner) {
          for (const float x : corner[axis]) low = std::min(low, x), high = std::max(high, x);
        }
        node.low[axis][leaf % kLanes] = low;
        node.high[axis][leaf % kLanes] = high;
      }
    }
  });
  while (levels_.back().size() > 1) {
    std::vector<BoxLanes>& next = add_level(levels_.back().size());
    const std::vector<BoxLanes>& below = levels_[levels_.size() - 2];
    for (std::size_t i = 0; i < below.size(); ++i) {
      BoxLanes& node = next[i / kLanes];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& low = below[i].low[axis];
        const auto& high = below[i].high[axis];
        node.low[axis][i % kLanes] = *std::min_element(std::begin(low), std::end(low));
        node.high[axis][i % kLanes] = *std::max_element(std::begin(high), std::end(high));
      }
    }
  }
}

struct TriangleTree::Best {
  double distance_sq;
  float box_bound_sq;  ///< boxes no farther are opened
  std::uint32_t triangle = kNone;

  void set(double square) {
    distance_sq = square;
    box_bound_sq = std::min(
        static_cast<float>(std::min(square, static_cast<double>(kLargest))) * kBoxMargin, kLargest);
  }
};

TrianglePlace TriangleTree::place_on(Vec3f p, std::uint32_t triangle) const {
  const Triangle& c = triangles_[triangle];
  return nearest_place(p.cast<double>(), positions_[c[0]].cast<double>(),
                       positions_[c[1]].cast<double>(), positions_[c[2]].cast<double>());
}

bool TriangleTree::faces(std::uint32_t triangle, Vec3f facing) const {
  if (facing == Vec3f{}) return true;
  const Triangle& c = triangles_[triangle];
  const Vec3f a = positions_[c[0]];
  return dot(cross(positions_[c[1]] - a, positions_[c[2]] - a), facing) > 0.0f;
}

void TriangleTree::try_leaf(const float (&p)[3], std::uint32_t leaf, const NearestQuery& query,
                            Best& best) const {
  double square[kLanes];
  std::uint32_t mask = near_triangles(leaves_[leaf], p, best.distance_sq, square);
  for (; mask != 0; mask &= mask - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(mask));
    if (square[k] > best.distance_sq) continue;
    const std::uint32_t triangle = order_[std::min(leaf * kLanes + k, order_.size() - 1)];
    if (square[k] == best.distance_sq && triangle > best.triangle) continue;
    if (!faces(triangle, query.facing)) continue;
    best.set(square[k]);
    best.triangle = triangle;
  }
}

void TriangleTree::search(const float (&p)[3], const NearestQuery& query, Best& best) const {
  // The bits of a distance, which rise with it, over level and number of a node; level 0: leaves.
  // At most seven siblings wait on each level.
  std::array<std::uint64_t, kMostLevels * kLanes> stack;
  std::size_t top = 0;
  stack[top++] = static_cast<std::uint64_t>(levels_.size()) << kNumberBits;
  while (top > 0) {
    const std::uint64_t entry = stack[--top];
    if (std::bit_cast<float>(static_cast<std::uint32_t>(entry >> 32)) > best.box_bound_sq) continue;
    const auto node = static_cast<std::uint32_t>(entry);
    const std::uint32_t level = node >> kNumberBits;
    const std::uint32_t number = node & ((std::uint32_t{1} << kNumberBits) - 1);
    if (level == 0) {
      try_leaf(p, number, query, best);
      if (best.triangle != kNone && best.distance_sq <= static_cast<double>(query.enough_sq))
        return;
      continue;
    }
    float square[kLanes];
    std::uint32_t mask = near_boxes(levels_[level - 1][number], p, best.box_bound_sq, square);
    const std::uint32_t first =
        (level - 1) << kNumberBits | number * static_cast<std::uint32_t>(kLanes);
    const std::size_t base = top;
    for (; mask != 0; mask &= mask - 1) {
      const int k = std::countr_zero(mask);
      const std::uint64_t child =
          static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(square[k])) << 32 |
          (first + static_cast<std::uint32_t>(k));
      // Nearest last, so that it is taken first.
      std::size_t at = top++;
      for (; at > base && stack[at - 1] < child; --at) stack[at] = stack[at - 1];
      stack[at] = child;
    }
  }
}

NearestPoint TriangleTree::nearest(Vec3f p, const NearestQuery& query) const {
  NearestPoint nearest;
  nearest.distance_sq = query.max_distance_sq;
  if (triangles_.empty()) return nearest;
  const float at[3] = {p.x, p.y, p.z};
  Best best{};
  best.set(static_cast<double>(query.max_distance_sq));
  if (query.guess < triangles_.size() && faces(query.guess, query.facing)) {
    const double guessed = place_on(p, query.guess).distance_sq * kGuessMargin;
    if (guessed < best.distance_sq) best.set(guessed);
  }
  search(at, query, best);
  if (best.triangle == kNone && query.guess < triangles_.size()) {
    // The guess is nearest, and rounding puts it beyond its own distance.
    best.set(static_cast<double>(query.max_distance_sq));
    search(at, query, best);
  }
  if (best.triangle == kNone) return nearest;
  const TrianglePlace place = place_on(p, best.triangle);
  nearest.triangle = best.triangle;
  nearest.distance_sq = static_cast<float>(place.distance_sq);
  nearest.u = static_cast<float>(place.u);
  nearest.v = static_cast<float>(place.v);
  return nearest;
}

Vec3f TriangleTree::point(const NearestPoint& nearest) const {
  const Triangle& c = triangles_[nearest.triangle];
  const Vec3f a = positions_[c[0]];
  return a + (positions_[c[1]] - a) * nearest.u + (positions_[c[2]] - a) * nearest.v;
}

Vec3f TriangleTree::normal(std::uint32_t triangle) const {
  const Triangle& c = triangles_[triangle];
  const Vec3f a = positions_[c[0]];
  return normalized(cross(positions_[c[1]] - a, positions_[c[2]] - a));
}

}  // namespace cornice
