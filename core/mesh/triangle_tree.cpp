// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/radix_sort.h"

namespace cornice {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 16;
constexpr int kKeyBits = 16;  // per axis
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct KeyedTriangle {
  std::uint64_t key;
  std::uint32_t triangle;
};

/// Spreads the low 16 bits to every third bit.
std::uint64_t spread(std::uint64_t x) {
  x = (x | (x << 16)) & 0x0000ff0000ffULL;
  x = (x | (x << 8)) & 0x00f00f00f00fULL;
  x = (x | (x << 4)) & 0x0c30c30c30c3ULL;
  return (x | (x << 2)) & 0x249249249249ULL;
}

float clamp_unit(float x) { return std::min(std::max(x, 0.0f), 1.0f); }

}  // namespace

NearestPoint nearest_on_triangle(Vec3f p, Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a;
  NearestPoint r;
  const auto at = [&](float u, float v) {
    const Vec3f d = ap - ab * u - ac * v;
    r.u = u, r.v = v, r.distance_sq = dot(d, d);
    return r;
  };
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0f && d2 <= 0.0f) return at(0.0f, 0.0f);
  const Vec3f bp = p - b;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0f && d4 <= d3) return at(1.0f, 0.0f);
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return at(clamp_unit(d1 / (d1 - d3)), 0.0f);
  const Vec3f cp = p - c;
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0f && d5 <= d6) return at(0.0f, 1.0f);
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return at(0.0f, clamp_unit(d2 / (d2 - d6)));
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0f && d4 - d3 >= 0.0f && d5 - d6 >= 0.0f) {
    const float w = clamp_unit((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    return at(1.0f - w, w);
  }
  const float sum = va + vb + vc;
  // Only a triangle without area gets here without a region of its own.
  if (!(sum > 0.0f)) return at(0.0f, 0.0f);
  return at(vb / sum, vc / sum);
}

TriangleTree::TriangleTree(const std::vector<Vec3f>& positions,
                           const std::vector<Triangle>& triangles, int threads)
    : positions_(positions), triangles_(triangles) {
  if (triangles_.empty()) return;
  sort_triangles(threads);
  build_levels(threads);
}

void TriangleTree::sort_triangles(int threads) {
  struct Bounds {
    Vec3f low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  };
  const Bounds box = parallel_reduce(
      positions_.size(), kGrain, threads, Bounds{},
      [&](std::size_t begin, std::size_t end) {
        Bounds b;
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3f p = positions_[i];
          b.low = {std::min(b.low.x, p.x), std::min(b.low.y, p.y), std::min(b.low.z, p.z)};
          b.high = {std::max(b.high.x, p.x), std::max(b.high.y, p.y), std::max(b.high.z, p.z)};
        }
        return b;
      },
      [](Bounds& a, const Bounds& b) {
        a.low = {std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y),
                 std::min(a.low.z, b.low.z)};
        a.high = {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y),
                  std::max(a.high.z, b.high.z)};
      });
  const Vec3f size = box.high - box.low;
  const float side = std::max({size.x, size.y, size.z, 1e-6f});
  const float scale = static_cast<float>((1 << kKeyBits) - 1) / side;
  const auto cell = [&](float value) {
    return spread(static_cast<std::uint64_t>(std::max(0.0f, value * scale)) & 0xffffu);
  };
  std::vector<KeyedTriangle> items(triangles_.size());
  parallel_for(items.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Triangle& c = triangles_[t];
      const Vec3f middle =
          (positions_[c[0]] + positions_[c[1]] + positions_[c[2]]) * (1.0f / 3.0f) - box.low;
      items[t] = {cell(middle.x) | (cell(middle.y) << 1) | (cell(middle.z) << 2),
                  static_cast<std::uint32_t>(t)};
    }
  });
  radix_sort(items, 0, 3 * kKeyBits, threads, [](const KeyedTriangle& item) { return item.key; });
  order_.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) order_[i] = items[i].triangle;
}

void TriangleTree::build_levels(int threads) {
  const auto empty_node = [] {
    Node node;
    for (int axis = 0; axis < 3; ++axis) {
      std::fill(std::begin(node.low[axis]), std::end(node.low[axis]), kInfinity);
      std::fill(std::begin(node.high[axis]), std::end(node.high[axis]), -kInfinity);
    }
    return node;
  };
  const std::size_t leaves = (order_.size() + kLeaf - 1) / kLeaf;
  levels_.emplace_back((leaves + kWidth - 1) / kWidth, empty_node());
  parallel_for(levels_[0].size(), 4096, threads, [&](std::size_t begin, std::size_t end) {
    const std::size_t first = begin * kWidth * kLeaf;
    const std::size_t last = std::min(end * kWidth * kLeaf, order_.size());
    for (std::size_t i = first; i < last; ++i) {
      Node& node = levels_[0][i / (kWidth * kLeaf)];
      const std::size_t child = i / kLeaf % kWidth;
      for (const std::uint32_t v : triangles_[order_[i]]) {
        const Vec3f p = positions_[v];
        const float at[3] = {p.x, p.y, p.z};
        for (int axis = 0; axis < 3; ++axis) {
          node.low[axis][child] = std::min(node.low[axis][child], at[axis]);
          node.high[axis][child] = std::max(node.high[axis][child], at[axis]);
        }
      }
    }
  });
  while (levels_.back().size() > 1) {
    std::vector<Node> next((levels_.back().size() + kWidth - 1) / kWidth, empty_node());
    const std::vector<Node>& below = levels_.back();
    for (std::size_t i = 0; i < below.size(); ++i) {
      Node& node = next[i / kWidth];
      for (int axis = 0; axis < 3; ++axis) {
        node.low[axis][i % kWidth] =
            *std::min_element(std::begin(below[i].low[axis]), std::end(below[i].low[axis]));
        node.high[axis][i % kWidth] =
            *std::max_element(std::begin(below[i].high[axis]), std::end(below[i].high[axis]));
      }
    }
    levels_.push_back(std::move(next));
  }
}

template <bool facing>
NearestPoint TriangleTree::search(Vec3f p, const NearestQuery& query) const {
  NearestPoint best;
  best.distance_sq = query.max_distance_sq;
  const auto try_triangle = [&](std::uint32_t t) {
    const Triangle& c = triangles_[t];
    const Vec3f a = positions_[c[0]], b = positions_[c[1]], d = positions_[c[2]];
    if constexpr (facing) {
      if (dot(cross(b - a, d - a), query.facing) <= 0.0f) return;
    }
    NearestPoint here = nearest_on_triangle(p, a, b, d);
    if (here.distance_sq < best.distance_sq ||
        (!best.found() && here.distance_sq <= best.distance_sq)) {
      best = here;
      best.triangle = t;
    }
  };
  if (query.guess < triangles_.size()) {
    try_triangle(query.guess);
    if (best.found() && best.distance_sq <= query.enough_sq) return best;
  }
  struct Entry {
    float distance_sq;
    std::uint32_t level;  // of the node; 0xffffffff: a leaf
    std::uint32_t index;
  };
  // At most seven siblings wait on each level.
  std::array<Entry, 8 * kWidth> stack;
  std::size_t top = 0;
  stack[top++] = {0.0f, static_cast<std::uint32_t>(levels_.size() - 1), 0};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.distance_sq > best.distance_sq) continue;
    if (entry.level == 0xffffffffu) {
      const std::size_t last = std::min<std::size_t>((entry.index + 1) * kLeaf, order_.size());
      for (std::size_t i = entry.index * kLeaf; i < last; ++i) try_triangle(order_[i]);
      if (best.found() && best.distance_sq <= query.enough_sq) return best;
      continue;
    }
    const Node& node = levels_[entry.level][entry.index];
    float distance_sq[kWidth];
    for (std::uint32_t k = 0; k < kWidth; ++k) {
      const float dx = std::max(std::max(node.low[0][k] - p.x, p.x - node.high[0][k]), 0.0f);
      const float dy = std::max(std::max(node.low[1][k] - p.y, p.y - node.high[1][k]), 0.0f);
      const float dz = std::max(std::max(node.low[2][k] - p.z, p.z - node.high[2][k]), 0.0f);
      distance_sq[k] = dx * dx + dy * dy + dz * dz;
    }
    const std::size_t base = top;
    for (std::uint32_t k = 0; k < kWidth; ++k) {
      if (!(distance_sq[k] <= best.distance_sq) || distance_sq[k] == kInfinity) continue;
      // Nearest last, so that it is taken first.
      std::size_t at = top++;
      while (at > base && stack[at - 1].distance_sq < distance_sq[k]) {
        stack[at] = stack[at - 1];
        --at;
      }
      stack[at] = {distance_sq[k], entry.level - 1, entry.index * kWidth + k};
    }
  }
  return best;
}

NearestPoint TriangleTree::nearest(Vec3f p, const NearestQuery& query) const {
  if (triangles_.empty()) return {};
  return query.facing == Vec3f{} ? search<false>(p, query) : search<true>(p, query);
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
