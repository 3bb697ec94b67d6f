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
  /// Bound of the two-sided distance for the original triangles [begin, end).
  float of(std::size_t begin, std::size_t end) { return begin_part(), add(begin, end), end_part(); }
  /// The same for several ranges together, less than for each: begin_part(), add() each,
  /// end_part().
  void begin_part();
  void add(std::size_t begin, std::size_t end);
  float end_part();

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
  /// The triangles round a vertex, filled up with the first again, or with such that are none.
  struct Fan {
    std::vector<FanLanes> lanes;
    std::vector<std::uint32_t> next, prev;
    bool is_ring = false;  ///< closed, and in one go
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
  /// An edge that may be the farthest, by a way that is at hand: infinity where there is none.
  struct Far {
    float distance;
    std::uint32_t a, b;
  };
  /// An edge and the coarse vertex round which its feet may lie.
  struct Edge {
    std::uint32_t a, b, middle;
  };
  struct Ways;
  void gather(std::uint32_t vertex, Fan& fan) const;
  void foot_in(const Fan& fan, std::uint32_t middle, Vec3f point, Foot& foot) const;
  void gather_ring(std::uint32_t vertex, const Link& link, Fan& fan) const;
  void find_all_feet();
  void find_feet(std::uint32_t parent);
  bool is_nearest_in_plan(const Fan& fan, Vec3f point, float square) const;
  void look_round(std::uint32_t vertex);
  float border_distance(std::uint32_t vertex) const;
  void list_edges(std::size_t begin, std::size_t end);
  void find_crossings();
  void pass(const Edge& edge);
  bool pass_between(const Edge& edge);
  bool pass_from_point(std::uint32_t a, std::uint32_t b);
  void pass_farther(std::uint32_t a, std::uint32_t b);
  void settle_crossings();
  void settle(const Crossings& crossings, std::size_t first, const Float8& square);
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
  std::vector<std::uint32_t> taken_;  ///< vertices that others became
  Fan fan_, farther_;
  // Of the part that is asked for: edges that pass over one or two coarse edges, the others, those
  // that a way is looked for, and the largest distance so far.
  Crossings once_, twice_;
  std::vector<Edge> edges_;
  std::size_t edge_count_ = 0;
  std::vector<Far> far_;
  float error_ = 0;
};

}  // namespace cornice::hlod
