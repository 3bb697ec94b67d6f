// SPDX-License-Identifier: GPL-3.0-or-later
// How far simplification moved the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hlod/simplify.h"

namespace cornice::hlod {

/// Distance between a surface and its simplification, cell by cell of a block. Thread contract: one
/// thread at a time.
///
/// Both surfaces are flat between the edges of the two, laid over one another; so the distance is
/// largest at a vertex of the fine one, where an edge of the one crosses an edge of the other, or
/// on a border. Every fine vertex that is gone gets its foot, a point on a coarse triangle; a fine
/// edge between two feet crosses coarse edges in between, where its distance is that to the planes
/// on both sides.
class StepError {
 public:
  /// fine: positions before rounding, same units as mesh.positions; original: the triangles before
  /// simplifier.run(mesh).
  void prepare(const SimplifyMesh& mesh, const Simplifier& simplifier, std::span<const Vec3f> fine,
               std::span<const Triangle> original);
  /// Bound of the two-sided distance for the original triangles [begin, end).
  float of(std::size_t begin, std::size_t end) const;

 private:
  struct Plane {
    float x = 0, y = 0, z = 0, w = 0;
    float at(Vec3f p) const { return x * p.x + y * p.y + z * p.z + w; }
  };
  void find_foot(std::uint32_t vertex);
  float border_distance(std::uint32_t vertex) const;
  std::uint32_t across(std::uint32_t triangle, std::size_t edge) const;
  float edge_error(std::uint32_t a, std::uint32_t b) const;

  const SimplifyMesh* mesh_ = nullptr;
  const Simplifier* simplifier_ = nullptr;
  std::span<const Vec3f> fine_;
  std::span<const Triangle> original_;
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> feet_;  ///< per vertex a coarse triangle, kNone where it stays
  std::vector<float> own_;           ///< per vertex its own distance
};

}  // namespace cornice::hlod
