// SPDX-License-Identifier: GPL-3.0-or-later
// Nearest points on a triangle mesh: an implicit tree of boxes over triangles sorted in space.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/mesh/topology.h"
#include "core/mesh/triangle_lanes.h"

namespace cornice {

/// A point of a triangle: a + u (b - a) + v (c - a).
struct NearestPoint {
  std::uint32_t triangle = 0xffffffffu;  ///< none was near enough
  float distance_sq = std::numeric_limits<float>::infinity();
  float u = 0.0f, v = 0.0f;

  bool found() const { return triangle != 0xffffffffu; }
};

/// A place a + u (b - a) + v (c - a) of a triangle, and its squared distance from a point.
struct TrianglePlace {
  double u = 0.0, v = 0.0;
  double distance_sq = 0.0;
};

/// The place of triangle (a, b, c) nearest to p; of triangles without area too. Right to 1e-7 of
/// the longest side, however long and thin the triangle is. Ericson 2005, "Real-Time Collision
/// Detection", 5.1.5.
TrianglePlace nearest_place(Vec3d p, Vec3d a, Vec3d b, Vec3d c);

/// The same rounded to floats; `triangle` is left unset.
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
/// const members may be called from many threads. Memory: 44 bytes a triangle.
class TriangleTree {
 public:
  TriangleTree(const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles,
               int threads);

  /// The nearest triangle in double precision, of several at the same distance the first; the same
  /// whatever the guess, unless enough_sq > 0.
  NearestPoint nearest(Vec3f p, const NearestQuery& query = {}) const;
  /// Where that point is.
  Vec3f point(const NearestPoint& nearest) const;
  Vec3f normal(std::uint32_t triangle) const;  ///< unit; zero without area

  /// All triangles in the tree's order: neighbours in it are near each other in space.
  const std::vector<std::uint32_t>& order() const { return order_; }
  const std::vector<Vec3f>& positions() const { return positions_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  struct Best;

  void sort_triangles(int threads);
  void fill_leaves(int threads);
  void build_levels(int threads);
  TrianglePlace place_on(Vec3f p, std::uint32_t triangle) const;
  bool faces(std::uint32_t triangle, Vec3f facing) const;
  void search(const float (&p)[3], const NearestQuery& query, Best& best) const;
  void try_leaf(const float (&p)[3], std::uint32_t leaf, const NearestQuery& query,
                Best& best) const;

  const std::vector<Vec3f>& positions_;
  const std::vector<Triangle>& triangles_;
  std::vector<std::uint32_t> order_;
  std::vector<TriangleLanes> leaves_;          ///< of eight triangles, in order
  std::vector<std::vector<BoxLanes>> levels_;  ///< [0]: boxes of leaves; the last has one node
};

}  // namespace cornice
