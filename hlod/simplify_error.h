// SPDX-License-Identifier: GPL-3.0-or-later
// How far simplification moved the surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hlod/simplify.h"
#include "hlod/simplify_distances.h"

namespace cornice::hlod {

/// Distance between a surface and its simplification, cell by cell of a block. Thread contract: one
/// thread at a time.
///
/// What is measured is how far a continuous map from the fine surface onto the coarse one moves any
/// point, which bounds the distance both ways. A fine vertex that stays is mapped to itself, any
/// other to its foot, the nearest point of the coarse triangles round its parent, or round those
/// where they may be nearer. Where the ends of a fine edge have their feet on different triangles,
/// the edge passes over the coarse edges in between, and for each of them the two points, one of
/// the fine edge and one of the coarse, that lie nearest to each other are mapped to each other.
/// Between these points everything is linear, so nothing moves farther than they do.
class StepError {
 public:
  /// fine: positions before rounding, same units as mesh.positions; original: the triangles before
  /// simplifier.run(mesh); shared: empty, or per vertex not 0 where triangles of several of the
  /// ranges that of() is asked for may have it.
  void prepare(const SimplifyMesh& mesh, const Simplifier& simplifier, std::span<const Vec3f> fine,
               std::span<const Triangle> original, std::span<const std::uint8_t> shared = {});
  /// Bound of the two-sided distance for the original triangles [begin, end), or `least` where that
  /// is above it: what is below is not looked for.
  float of(std::size_t begin, std::size_t end, float least = 0);

 private:
  /// The triangles round a vertex, filled up with the first again.
  struct Fan {
    std::vector<FanLanes> lanes;
    std::vector<std::uint32_t> triangles;
  };
  struct Foot {
    float square;
    std::uint32_t triangle;
    bool is_beyond;  ///< at the rim of the triangles that were looked at
  };
  class Crossings;
  struct Ways;
  void gather(std::uint32_t vertex, Fan& fan) const;
  Foot foot_in(const Fan& fan, Vec3f point) const;
  void find_feet(std::uint32_t parent);
  void look_round(std::uint32_t vertex, std::uint32_t parent, Foot& foot);
  float border_distance(std::uint32_t vertex) const;
  std::uint32_t across(std::uint32_t triangle, std::size_t e) const;
  bool may_pass(std::uint32_t a, std::uint32_t b) const;
  void pass(std::uint32_t a, std::uint32_t b, Crossings& crossings) const;
  void pass_from_vertex(std::uint32_t a, std::uint32_t b, Crossings& crossings) const;
  float search(std::uint32_t a, std::uint32_t b) const;

  const SimplifyMesh* mesh_ = nullptr;
  const Simplifier* simplifier_ = nullptr;
  std::span<const Vec3f> fine_;
  std::span<const Triangle> original_;
  std::vector<std::uint32_t> feet_;  ///< per vertex a coarse triangle, kNone where it stays
  std::vector<float> own_;           ///< per vertex its own distance
  /// 1 where the edges of a vertex are met twice, from both their sides, in the same range.
  std::vector<std::uint8_t> within_;
  /// Lists of what became each vertex: the first, and per vertex the next of its list.
  std::vector<std::uint32_t> first_, next_;
  Fan fan_, farther_;
  std::vector<std::array<std::uint32_t, 2>> passing_;  ///< edges of the range that is asked for
};

}  // namespace cornice::hlod
