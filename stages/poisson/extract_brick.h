// SPDX-License-Identifier: GPL-3.0-or-later
// One brick of the finest lattice with a rim of one node: which edges the surface crosses, which
// vertices are made one, and what comes out of that.
//
// Vertices that lie close to a node n on several of its edges would make slivers. They are made one
// vertex, placed on their mean. That leaves the surface a manifold, because it is done only where
//   - of the two neighbours of n along an axis at most one has the other sign, and
//   - no face of a cell with n as a corner is ambiguous.
// The crossed edges of n are then at most three, perpendicular in pairs, and any two of them are
// joined by the surface on the face between them, so what is drawn together is a vertex, an edge or
// a triangle. Two welded nodes n, m that are neighbours along a lattice edge are joined by surface
// edges on at most two of its four faces, which are next to each other; the loop of the cell
// between these has become (n, m) and vanishes, so that one edge stays. All other pairs of nodes
// share one face at most, which has one surface edge. Snapping into nodes goes back to Raman &
// Wenger, "Quality isosurface mesh generation using an extended marching cubes lookup table"
// (2008); here the topology is theirs in effect, but the vertex stays on the surface.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "stages/poisson/extract.h"
#include "stages/poisson/extract_polygon.h"

namespace cornice {

/// The kinds of vertex that a node owns, in their order.
enum class VertexKind : std::uint8_t { kNode = 0, kAlongX = 1, kAlongY = 2, kAlongZ = 3 };

/// Which vertices a brick owns, four bits a node, and how to number them.
struct VertexTable {
  std::array<std::uint64_t, 32> mask{};
  std::array<std::uint16_t, 32> before{};  ///< bits in the words before

  void set(int node, VertexKind kind) {
    const int bit = 4 * node + static_cast<int>(kind);
    mask[static_cast<std::size_t>(bit >> 6)] |= std::uint64_t{1} << (bit & 63);
  }
  /// Fills `before`; returns how many there are.
  std::uint32_t number();
  std::uint32_t rank(int node, VertexKind kind) const;
  /// How many of them are of kind kNode.
  std::size_t welded() const;
};

/// Values of bricks, computed once where they are not stored. Thread contract: one thread.
class BrickCache {
 public:
  explicit BrickCache(const NodeValues& values) : values_(values) {}
  /// The 512 nodes of a brick, null where none is known. Valid while the cache lives.
  struct Nodes {
    const float* values = nullptr;
    bool all_known = false;
  };
  Nodes nodes(BrickKey brick);

 private:
  struct Computed {
    std::unique_ptr<std::array<float, kBrickNodes>> values;  ///< null: none is known
    bool all_known = false;
  };
  struct Hash {
    std::size_t operator()(BrickKey b) const;
  };

  const NodeValues& values_;
  std::unordered_map<BrickKey, Computed, Hash> computed_;
};

/// The part of the options that a brick needs, in nodes of the lattice.
struct BrickRules {
  LatticeBox window;
  std::vector<LatticeBox> borders;
  std::int32_t weld_units = 0;
};

/// Names a vertex.
struct BrickVertex {
  int node = 0;  ///< of the padded brick
  VertexKind kind = VertexKind::kNode;
};

/// A vertex in the middle of a loop, as of BrickSurface::cut().
struct CentreVertex {
  Vec3<std::int32_t> position;  ///< units from node (0, 0, 0) of the brick
  Vec3f normal;
};

/// Thread contract: one thread.
class BrickSurface {
 public:
  static constexpr std::uint32_t kCentre = 4 * 2048;
  static constexpr int kSide = kBrickSide + 3;  ///< nodes -1 .. 9
  static constexpr int kNodes = kSide * kSide * kSide;
  static constexpr int at(int i, int j, int k) { return i + 1 + kSide * (j + 1 + kSide * (k + 1)); }

  explicit BrickSurface(const BrickRules& rules);
  BrickSurface(const BrickSurface&) = delete;
  BrickSurface& operator=(const BrickSurface&) = delete;

  /// Reads a brick and finds its crossings and welds. False where no sign changes in it or its rim.
  bool load(BrickKey brick, BrickCache& cache);
  /// True where part of the rim or brick is not known.
  bool incomplete() const { return !all_known_; }
  /// The vertices that the brick owns and its window uses.
  VertexTable vertices() const;
  /// Bricks around this one that the surface goes on into or that own vertices of this one's cells:
  /// bit (dx + 1) + 3 (dy + 1) + 9 (dz + 1).
  std::uint32_t neighbours_needed() const;

  /// Where the vertex is: units from node (0, 0, 0) of the brick.
  Vec3<std::int32_t> position(BrickVertex vertex) const;
  /// Unit vector along the gradient there.
  Vec3f normal(BrickVertex vertex) const;
  /// Cuts the surface in the window's cells into triangles. Their corners are vertex codes, 4 *
  /// padded node + kind; those from kCentre on are kCentre + the number of a new vertex in
  /// `centres`.
  void cut(std::vector<std::array<std::uint32_t, 3>>& triangles,
           std::vector<CentreVertex>& centres) const;

 private:
  using Rows = std::array<std::uint16_t, kSide * kSide>;

  void gather(BrickCache& cache);
  void copy_nodes(const float* from, int dx, int dy, int dz);
  void read_signs();
  void find_crossings();
  void add_crossings(unsigned bits, int row, int axis);
  void weld();
  std::uint8_t weld_of(int node) const;
  unsigned constrained_axes(int node) const;
  unsigned cells_of_row(int j, int k) const;
  unsigned joined_faces(int node, unsigned negative, unsigned ambiguous) const;
  BrickVertex vertex_on(int node, int axis) const;
  LoopCorner corner_on(int cell, unsigned edge) const;
  std::size_t make_corners(int cell, const std::uint8_t* edges, std::size_t length,
                           std::array<LoopCorner, kMaxLoop>& corners) const;
  CentreVertex centre_of(int cell, std::span<const LoopCorner> corners) const;
  void cut_cell(int cell, std::vector<std::array<std::uint32_t, 3>>& triangles,
                std::vector<CentreVertex>& centres) const;
  unsigned signs_of_cell(int cell) const;
  unsigned crossings(int row, int axis) const;
  Vec3f gradient(int node) const;
  bool is_negative(int node) const { return values_[static_cast<std::size_t>(node)] < 0.0f; }

  const BrickRules& rules_;
  BrickKey brick_;
  std::vector<LatticeBox> planes_;         ///< borders that touch the brick
  int x0_ = 0, x1_ = 0, y0_ = 0, y1_ = 0;  ///< the window, in nodes of the brick
  bool all_known_ = true;
  std::array<float, kNodes> values_{};
  Rows negative_{};  ///< bit i + 1: node i is below 0
  Rows known_{};
  std::array<std::array<std::int16_t, kNodes>, 3> units_{};  ///< of the crossing, by axis and node
  std::array<std::uint8_t, kNodes> near_{};  ///< directions (bits) of crossings close to a node
  std::array<std::uint8_t, kNodes> weld_{};  ///< directions (bits) of those that are made one
  std::vector<std::int16_t> touched_;
  std::vector<std::int16_t> crowded_;
};

}  // namespace cornice
