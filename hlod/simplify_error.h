// SPDX-License-Identifier: GPL-3.0-or-later
// How far simplification moved the surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hlod/simplify.h"

namespace cornice::hlod {

/// Distance between a surface and its simplification, cell by cell of a block. Thread contract: one
/// thread at a time.
///
/// What is measured is how far a continuous map from the fine surface onto the coarse one moves any
/// point, which bounds the distance both ways. A fine vertex that stays is mapped to itself, any
/// other to its foot, a point of a coarse triangle found by walking. Where the ends of a fine edge
/// have their feet on different triangles, the edge passes over the coarse edges in between, and
/// for each of them the two points, one of the fine edge and one of the coarse, that lie nearest to
/// each other are mapped to each other. Between these points everything is linear, so nothing
/// moves farther than they do.
class StepError {
 public:
  /// fine: positions before rounding, same units as mesh.positions; original: the triangles before
  /// simplifier.run(mesh); shared: empty, or per vertex not 0 where triangles of several of the
  /// ranges that of() is asked for may have it.
  void prepare(const SimplifyMesh& mesh, const Simplifier& simplifier, std::span<const Vec3f> fine,
               std::span<const Triangle> original, std::span<const std::uint8_t> shared = {});
  /// Bound of the two-sided distance for the original triangles [begin, end).
  float of(std::size_t begin, std::size_t end) const;

 private:
  struct Ways;
  void find_foot(std::uint32_t vertex);
  void find_nearest(std::uint32_t vertex, std::uint32_t at);
  float border_distance(std::uint32_t vertex) const;
  void find_neighbours();
  bool is_met_twice(std::uint32_t a, std::uint32_t b) const;
  float edge_error(std::uint32_t a, std::uint32_t b, float enough) const;
  float over(std::uint32_t a, std::uint32_t b, std::uint32_t triangle, std::size_t e) const;
  float search(std::uint32_t a, std::uint32_t b) const;

  const SimplifyMesh* mesh_ = nullptr;
  const Simplifier* simplifier_ = nullptr;
  std::span<const Vec3f> fine_;
  std::span<const Triangle> original_;
  std::span<const std::uint8_t> shared_;
  std::vector<std::uint32_t> feet_;  ///< per vertex a coarse triangle, kNone where it stays
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<float> own_;  ///< per vertex its own distance
};

}  // namespace cornice::hlod
