// SPDX-License-Identifier: GPL-3.0-or-later
// Whether what is drawn of a hierarchy is whole: cells chosen, vertices morphed in whole numbers,
// triangles put together, every edge counted.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "hlod/file.h"
#include "hlod/select.h"

namespace cornice::bench {

/// A hierarchy in memory: nodes sorted by key and part, one mesh per node.
struct Hierarchy {
  hlod::Header header;
  std::vector<hlod::Node> nodes;
  std::vector<hlod::CellMesh> meshes;
};
Hierarchy load_hierarchy(const std::filesystem::path& path);

/// What one eye sees. Open edges are those whose triangles do not cancel: as many along it one way
/// as the other way, after triangles without three different corners are left out and the survey's
/// own border, drawn where its finest triangles are drawn, is taken away.
struct Drawn {
  std::uint64_t cells = 0, triangles = 0, degenerate = 0;
  std::uint64_t open_edges = 0;
  std::uint64_t crowded_edges = 0;  ///< with more than two triangles, though they cancel
  std::uint64_t level_jumps = 0;    ///< pairs of touching cells two levels or more apart
};

/// Thread contract: one thread at a time; make one for each.
class CrackChecker {
 public:
  /// Throws InputError where vertices at one position have several parents, or a parent is no
  /// vertex of its level. The hierarchy must outlive it.
  explicit CrackChecker(const Hierarchy& hierarchy);

  const hlod::Tree& tree() const { return tree_; }
  Drawn check(hlod::FinePoint eye, const hlod::Radii& radii);

  /// Of the last check: where every vertex of the finest level is drawn, fine steps seen from the
  /// eye, and the drawn triangles. A vertex of several cells is taken from the first.
  const std::vector<hlod::FinePoint>& finest_vertices();
  std::vector<std::array<hlod::FinePoint, 3>> triangles() const;
  /// Largest error in metres that the cells drawn stand for: their own where they are drawn as they
  /// are, their parents' where they may be morphed.
  double error_bound_m() const;

  /// Largest way from a vertex to its parent, max norm, and largest edge, each as a share of s0
  /// times what the level allows (plan only in quadtrees): at most 1 in a sound hierarchy.
  double parent_share() const { return parent_share_; }
  double edge_share() const { return edge_share_; }
  std::size_t finest_vertex_count() const { return levels_.back().positions.size(); }

 private:
  struct Level {
    std::vector<hlod::LatticePoint> positions;
    std::vector<std::uint32_t> parents;       ///< vertex of the level above
    std::vector<std::uint32_t> drawn, stamp;  ///< position number of this check, where stamp fits
  };
  struct Edge {
    std::uint64_t key = ~std::uint64_t{0};
    std::int32_t net = 0;
    std::uint32_t users = 0;
  };
  struct BorderEdge {
    std::uint32_t from, to, cell;  ///< vertices of the finest level, cell of the tree
    std::int32_t times;
  };

  void number_vertices();
  void measure_shares();
  void find_border();
  void find_neighbours();
  std::uint32_t place(int level, std::uint32_t vertex);
  std::uint32_t place_number(hlod::FinePoint p);
  void add_edge(std::uint32_t from, std::uint32_t to, std::int32_t times);
  void add_cell(std::uint32_t cell, Drawn& drawn);
  void mark_drawn(const hlod::Radii& radii);
  void add_border();
  std::uint32_t ancestor(std::uint32_t vertex, int level) const;
  std::uint32_t drawn_ancestor(std::uint32_t cell) const;

  const Hierarchy& hierarchy_;
  hlod::Tree tree_;
  std::vector<Level> levels_;
  std::vector<std::vector<std::uint32_t>> vertex_of_;  ///< per mesh: number in its level
  std::vector<std::uint32_t> parent_cell_;             ///< of each cell of the tree
  std::vector<BorderEdge> border_;
  std::vector<std::array<std::uint32_t, 2>> neighbours_;  ///< cells of the finest level that touch
  std::vector<std::uint32_t> cell_of_finest_;             ///< a cell of each finest vertex
  double parent_share_ = 0.0, edge_share_ = 0.0;

  // Of the check that runs.
  std::uint32_t check_ = 0;
  hlod::FinePoint eye_;
  std::int32_t slab_ = 0;
  std::vector<hlod::MorphBand> bands_;
  hlod::Selection selection_;
  std::vector<std::uint32_t> drawn_check_;  ///< per cell: the last check in which it was drawn
  std::vector<hlod::FinePoint> places_;
  std::vector<std::uint32_t> place_table_;
  std::vector<Edge> edges_;
  std::size_t edge_count_ = 0;
  std::vector<hlod::FinePoint> finest_;
};

}  // namespace cornice::bench
