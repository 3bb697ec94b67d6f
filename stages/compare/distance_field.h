// SPDX-License-Identifier: GPL-3.0-or-later
// Signed distances to a surface.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "core/mesh/triangle_tree.h"
#include "stages/compare/surface.h"

namespace cornice::compare {

/// What lies nearest to a place.
struct Foot {
  float distance_m = std::numeric_limits<float>::quiet_NaN();  ///< NaN: nothing near enough
  bool beside = false;  ///< the surface ends there, and the place lies past its edge
  std::uint32_t triangle = 0xffffffffu;  ///< of clouds: the point

  bool found() const { return triangle != 0xffffffffu; }
};

/// Keeps a reference to `surface`. Thread contract: const members may be called from many threads.
/// Memory: about 80 bytes a triangle.
class DistanceField {
 public:
  DistanceField(const Surface& surface, int threads);
  DistanceField(const DistanceField&) = delete;
  DistanceField& operator=(const DistanceField&) = delete;

  /// The distance of `p` (in the surface's frame), positive outside, in front of the triangles; of
  /// clouds never negative. `guess`, a triangle that may be near, makes the search short.
  Foot at(Vec3f p, float max_distance_m, std::uint32_t guess = 0xffffffffu) const;
  /// Unit normal of a triangle; up for clouds.
  Vec3f normal(std::uint32_t triangle) const;
  bool is_cloud() const { return !points_.empty(); }

 private:
  /// The normal that decides on the sign, not unit; sets `on_border` where the surface ends.
  Vec3f pseudonormal(std::uint32_t triangle, const std::array<float, 3>& weight,
                     bool& on_border) const;

  std::vector<Triangle> points_;  ///< of clouds: one triangle without area a point
  TriangleTree tree_;
  std::vector<Vec3f> normals_;        ///< of vertices
  std::vector<std::uint32_t> twins_;  ///< of half-edges
  std::vector<std::uint8_t> border_;  ///< of vertices
};

}  // namespace cornice::compare
