// SPDX-License-Identifier: GPL-3.0-or-later
// How far simplification moved the surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hlod/lanes.h"
#include "hlod/simplify.h"
#include "hlod/simplify_distances.h"

namespace cornice::hlod {

/// Distance between a surface and its simplification, cell by cell of a block. Thread contract: one
/// thread at a time.
///
/// What is measured is how far a continuous map from the fine surface onto the coarse one moves any
/// point, which bounds the distance both ways. A fine vertex that stays is mapped to itself, any
/// other to its foot, the nearest point of the coarse triangles round its parent, or of those round
/// it where one of them may be nearer. Where the ends of a fine edge have their feet on different
/// triangles, the edge passes over the coarse edges in between, and for each of them the two
/// points, one of the fine edge and one of the coarse, that lie nearest to each other are mapped to
/// each other. Between these points everything is linear, so nothing moves farther than they do.
class StepError {
 public:
  /// fine: positions before rounding, same units as mesh.positions; original: the triangles before
  /// simplifier.run(mesh); shared: empty, or per vertex not 0 where triangles of several of the
  /// ranges that of() is asked for may have it.
  void prepare(const Simplifier& simplifier, std::span<const Float4> fine,
               std::span<const Triangle> original, std::span<const std::uint8_t> shared = {});
  /// Bound of the two-sided distance for the original triangles [begin, end), or `least` where that
  /// is above it: what is below is not looked for.
  float of(std::size_t begin, std::size_t end, float least = 0);

 private:
  /// Where a fine vertex is mapped to: a coarse triangle by its corners, or thrice one vertex.
  struct alignas(16) Foot {
    Triangle corners;
    float distance;  ///< squared and below 0 in foot_in(): beyond the fan's rim may be a nearer one

    bool is_point() const { return corners[0] == corners[1]; }
    bool has(std::uint32_t v) const {
      return (int{corners[0] == v} | int{corners[1] == v} | int{corners[2] == v}) != 0;
    }
  };
  /// The triangles round a vertex, filled up with the first again.
  struct Fan {
    std::vector<FanLanes> lanes;
    std::vector<std::uint32_t> next, prev;
  };
  /// Edges of the fine surface from a to b with the coarse edges from p to q, and then from p to r,
  /// that they pass over.
  struct Crossings {
    std::vector<std::uint32_t> a, b, p, q, r;
    std::size_t count = 0;

    void add(std::uint32_t from, std::uint32_t to, const Triangle& over);
    void make_room(std::size_t more);
    void fill_up();
  };
  struct Ways;
  void gather(std::uint32_t vertex, Fan& fan) const;
  void foot_in(const Fan& fan, std::uint32_t middle, Vec3f point, Foot& foot) const;
  void find_all_feet();
  void find_feet(std::uint32_t parent);
  void look_round(std::uint32_t vertex);
  float border_distance(std::uint32_t vertex) const;
  float list_edges(std::size_t begin, std::size_t end, float least);
  void find_crossings();
  float pass(std::uint32_t a, std::uint32_t b, float error);
  bool pass_between(std::uint32_t a, std::uint32_t b);
  bool pass_from_point(std::uint32_t a, std::uint32_t b);
  float pass_farther(std::uint32_t a, std::uint32_t b, float error) const;
  float settle_crossings(float error);
  float settle(const Crossings& crossings, std::size_t first, const Float8& square, float error);
  std::uint32_t across(const Triangle& triangle, std::size_t e) const;
  float go_round(std::uint32_t a, std::uint32_t b, std::uint32_t middle) const;
  float search(std::uint32_t a, std::uint32_t b) const;
  Vec3f coarse(std::uint32_t vertex) const { return vector_of(simplifier_->places()[vertex]); }
  Vec3f fine(std::uint32_t vertex) const { return vector_of(fine_[vertex]); }
  static Vec3f vector_of(const Float4& p) { return {p[0], p[1], p[2]}; }

  const Simplifier* simplifier_ = nullptr;
  std::span<const Float4> fine_;
  std::span<const Triangle> original_;
  std::vector<Foot> feet_;
  /// 1 where the edges of a vertex are met twice, from both their sides, in the same range.
  std::vector<std::uint8_t> within_;
  /// Lists of what became each vertex: the first, and per vertex the next of its list.
  std::vector<std::uint32_t> first_, next_;
  Fan fan_, farther_;
  // Of the range that is asked for: edges that pass over one or two coarse edges, and the others.
  Crossings once_, twice_;
  std::vector<std::array<std::uint32_t, 2>> edges_;
};

}  // namespace cornice::hlod
