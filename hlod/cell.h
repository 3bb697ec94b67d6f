// SPDX-License-Identifier: GPL-3.0-or-later
// One cell of a hierarchy: its place, its mesh, and what the node table says of it.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

#include "hlod/lattice.h"

namespace cornice::hlod {

/// How space is halved from level to level.
enum class Partition : std::uint8_t {
  kQuadtree,  ///< columns, k = 0: DEMs and gentle ground
  kOctree,    ///< cubes: walls and overhangs
};

/// Place of a cell: cell (i, j, k) of a level begins at (i, j, k) * cell side from the origin.
/// Ordered by level, then i, j, k.
struct CellKey {
  int level = 0;
  std::int32_t i = 0, j = 0, k = 0;

  friend constexpr auto operator<=>(const CellKey&, const CellKey&) = default;
  /// The cell of the next coarser level that holds this one; level must be above 0.
  constexpr CellKey parent() const { return {level - 1, i >> 1, j >> 1, k >> 1}; }
};

/// Which optional attributes every vertex of a hierarchy has.
enum AttributeBits : std::uint32_t {
  kHasSupport = 1,  ///< distance to the nearest measured point
  kHasSource = 2,   ///< measured, bridged, DEM; or a class
  kHasColour = 4,   ///< red, green, blue
  kHasTexture = 8,  ///< texture coordinates
};

/// A vertex as stored. Attributes that the hierarchy does not have are 0.
struct CellVertex {
  LatticePoint position;                 ///< steps of the vertex's own level
  std::array<std::int16_t, 2> normal{};  ///< octahedral, see octahedral.h
  std::uint16_t support = 0;             ///< steps of 1 cm, the largest value: that or more
  std::uint8_t source = 0;
  std::array<std::uint8_t, 3> colour{};
  std::array<std::uint16_t, 2> texture{};  ///< 0..65535 for 0..1

  friend bool operator==(const CellVertex&, const CellVertex&) = default;
};

/// Mesh of a cell of level l: the triangles whose barycentre (at the finest level) or whose
/// children's triangles (above it) lie in the cell. Triangles are not cut at cell borders; a vertex
/// lies at most s0 * cell side outside of its cell (max norm).
///
/// Every vertex v has a parent vertex P(v) of level l-1, stored whole so that a cell can be morphed
/// without its parent cell: P(v) = parents[parent_of[v]], position in steps of level l-1.
/// The root level has neither parents nor parent_of.
struct CellMesh {
  CellKey key;
  std::vector<CellVertex> vertices;      ///< at most 65535, no two at the same position
  std::vector<CellVertex> parents;       ///< at most one per vertex
  std::vector<std::uint16_t> parent_of;  ///< one per vertex, index into parents
  std::vector<std::array<std::uint16_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// One row of the node table. A cell with more vertices than 16 bits index is stored as several
/// parts, each with its own row and the same key.
struct Node {
  CellKey key;
  std::uint16_t part = 0;
  LatticePoint lowest, highest;  ///< box of vertices and of their parents, steps of the key's
                                 ///< level; both ends belong to it
  float error_m = 0;  ///< bound of the two-sided distance to the finest level's surface, metres;
                      ///< never below a child's
  float step_error_m = 0;  ///< the part of it that this level's simplification added
  std::uint32_t triangles = 0, vertices = 0, parents = 0;
  std::uint64_t offset = 0;  ///< bytes from the file's beginning
  std::uint32_t bytes = 0;
  std::uint64_t checksum = 0;  ///< XXH3 of the bytes
};

}  // namespace cornice::hlod
