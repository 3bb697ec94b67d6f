// SPDX-License-Identifier: GPL-3.0-or-later
// Nearest points on a triangle mesh: an implicit tree of boxes over triangles in Morton order.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice {

/// A point of a triangle: a + u (b - a) + v (c - a).
struct NearestPoint {
  std::uint32_t triangle = 0xffffffffu;  ///< none was near enough
  float distance_sq = std::numeric_limits<float>::infinity();
  float u = 0.0f, v = 0.0f;

  bool found() const { return triangle != 0xffffffffu; }
};

/// The point of triangle (a, b, c) nearest to p; `triangle` is left unset.
/// Ericson 2005, "Real-Time Collision Detection", 5.1.5.
NearestPoint nearest_on_triangle(Vec3f p, Vec3f a, Vec3f b, Vec3f c);

/// What a search may stop at, and what it may return.
struct NearestQuery {
  float max_distance_sq = std::numeric_limits<float>::infinity();
  float enough_sq = 0.0f;             ///< anything as near as this will do
  std::uint32_t guess = 0xffffffffu;  ///< a triangle that may be near: makes the search short
  Vec3f
      facing{};  ///< where not zero: only triangles whose normal makes less than 90 degrees with it
};

/// Keeps references to the arrays it is made of, which must stay as they are. Thread contract:
/// const members may be called from many threads. Memory: 12 bytes a triangle (32 while it is
/// built).
class TriangleTree {
 public:
  TriangleTree(const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles,
               int threads);

  /// The same answer whatever the guess, unless enough_sq > 0; of several triangles at the same
  /// distance any may be named.
  NearestPoint nearest(Vec3f p, const NearestQuery& query = {}) const;
  /// Where that point is.
  Vec3f point(const NearestPoint& nearest) const;
  Vec3f normal(std::uint32_t triangle) const;  ///< unit; zero without area

  /// All triangles in the tree's order: neighbours in it are near each other in space.
  const std::vector<std::uint32_t>& order() const { return order_; }
  const std::vector<Vec3f>& positions() const { return positions_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  static constexpr std::uint32_t kLeaf = 4;   ///< triangles in a box of the lowest level
  static constexpr std::uint32_t kWidth = 8;  ///< boxes in a node

  /// The boxes of eight children.
  struct Node {
    float low[3][kWidth];
    float high[3][kWidth];
  };
  void sort_triangles(int threads);
  void build_levels(int threads);
  template <bool facing>
  NearestPoint search(Vec3f p, const NearestQuery& query) const;

  const std::vector<Vec3f>& positions_;
  const std::vector<Triangle>& triangles_;
  std::vector<std::uint32_t> order_;
  std::vector<std::vector<Node>> levels_;  ///< [0]: over leaves; the last has one node
};

}  // namespace cornice
