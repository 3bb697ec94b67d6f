// SPDX-License-Identifier: GPL-3.0-or-later
// Edges of the borders that have no partner, and what lies near them.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "stages/stitch/border.h"
#include "stages/stitch/match.h"

namespace cornice::stitch {

/// The borders without their matching edges; numbers are those of all borders together.
/// Thread contract: const members may be called from many threads.
class LooseBorders {
 public:
  LooseBorders(const Borders& borders, const Matches& matches, double tolerance_m);

  /// The place of an edge that is nearest to a vertex.
  struct Near {
    std::uint32_t edge = kNone;
    double t = 0.0;  ///< from + t (to - from)
    double distance_m = 0.0;
  };
  /// For every other tile the loose edge nearest to loose vertex v, by tile: within reach, running
  /// the other way, facing the same side, and nearest inside the edge rather than at its ends.
  std::vector<Near> edges_near(std::uint32_t v) const;
  /// The same for any point with a direction and a normal, of tile `own`.
  std::vector<Near> edges_near(Vec3d p, Vec3d in, Vec3d out, Vec3d normal, double length_m,
                               std::uint32_t own) const;

  /// Whether two loose vertices of different tiles may be one: their distance is within reach, a
  /// border runs the one way through the first and the other way through the second, and both face
  /// the same side.
  bool may_join(std::uint32_t v, std::uint32_t w) const;

  bool is_loose(std::uint32_t v) const { return in_[v] != kNone || out_[v] != kNone; }
  const std::vector<std::uint32_t>& loose_edges() const { return loose_; }
  const std::vector<std::uint32_t>& loose_vertices() const { return vertices_; }
  const std::vector<BorderEdge>& edges() const { return edges_; }
  const std::vector<Vec3d>& positions() const { return positions_; }
  std::uint32_t tile_of(std::uint32_t v) const { return vertex_tiles_[v]; }
  std::uint32_t in(std::uint32_t v) const { return in_[v]; }    ///< loose edge that ends at v
  std::uint32_t out(std::uint32_t v) const { return out_[v]; }  ///< loose edge that starts at v
  Vec3d along(std::uint32_t edge) const {
    return positions_[edges_[edge].to] - positions_[edges_[edge].from];
  }
  double length(std::uint32_t edge) const { return norm(along(edge)); }
  /// Longest loose edge at v.
  double length_at(std::uint32_t v) const;
  /// How near borders with edges of these lengths must be to be one.
  double reach(double length_a, double length_b) const;

 private:
  using Cell = std::pair<std::uint64_t, std::uint32_t>;
  void fill_grid();
  std::uint64_t cell_of(std::int64_t x, std::int64_t y, std::int64_t z) const;
  Vec3d normal_at(std::uint32_t v) const;

  double tolerance_m_;
  std::vector<BorderEdge> edges_;
  std::vector<Vec3d> positions_;
  std::vector<std::uint32_t> vertex_tiles_;
  std::vector<std::uint32_t> loose_, vertices_;
  std::vector<std::uint32_t> in_, out_;
  Vec3d corner_;
  double cell_m_ = 1.0;
  std::vector<Cell> cells_;  ///< sorted
};

}  // namespace cornice::stitch
