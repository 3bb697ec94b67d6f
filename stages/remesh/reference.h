// SPDX-License-Identifier: GPL-3.0-or-later
// The input, as the surface that everything is measured against.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/triangle_tree.h"

namespace cornice::remesh {

/// Keeps references to the arrays it is made of. Thread contract: const members may be called from
/// many threads. Memory: 12 bytes a triangle for the tree, 12 for the twins, 2 for the vertices.
class Reference {
 public:
  /// `twins` as match_half_edges() gives them for `triangles`.
  Reference(const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles,
            std::vector<std::uint32_t> twins, int threads);

  const std::vector<Vec3f>& positions() const { return tree_.positions(); }
  const std::vector<Triangle>& triangles() const { return tree_.triangles(); }
  const std::vector<std::uint32_t>& twins() const { return twins_; }
  const TriangleTree& tree() const { return tree_; }
  /// One of the triangles at a vertex; kNoTriangle where there is none.
  std::uint32_t triangle_at(std::uint32_t vertex) const { return at_[vertex]; }
  static constexpr std::uint32_t kNoTriangle = 0xffffffffu;

  /// A place at p's side of the surface that no neighbour of its triangle comes nearer to: steps
  /// from triangle to triangle, begun at `from`, until none is nearer or one is near enough. Stays
  /// on the sheet where it starts; seldom the nearest place where the surface is folded.
  NearestPoint walk(Vec3f p, std::uint32_t from, float enough_sq) const;
  /// A walk that stops where it is nearer than `enough_sq`, and a search where it ends farther away
  /// than `search_sq`: then the nearest place of all.
  /// Without u and v where no search was needed.
  NearestPoint near(Vec3f p, std::uint32_t from, float enough_sq, float search_sq) const;
  /// Whether some place of the surface is that near; `from` becomes a triangle near p.
  bool is_near(Vec3f p, std::uint32_t& from, float enough_sq) const;

 private:
  NearestPoint measure(Vec3f p, std::uint32_t triangle) const;
  /// The squared distance of a triangle, or most_sq where it is farther than that.
  float distance_sq(Vec3f p, std::uint32_t triangle, float most_sq) const;
  /// The triangle below or above p, and how near that is: each step leaves by the side that p lies
  /// farthest beyond.
  std::uint32_t stride(Vec3f p, std::uint32_t from, float& found_sq) const;
  /// Where the walk ends, and how near that is.
  std::uint32_t step_down(Vec3f p, std::uint32_t from, float enough_sq, float& found_sq) const;

  TriangleTree tree_;
  std::vector<std::uint32_t> twins_;
  std::vector<std::uint32_t> at_;
};

}  // namespace cornice::remesh
