// SPDX-License-Identifier: GPL-3.0-or-later
// A cell on its way through the builder.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"
#include "hlod/cell.h"

namespace cornice::hlod {

/// Mesh of a cell of any size, before its parents are known.
struct BuildCell {
  CellKey key;
  std::vector<CellVertex> vertices;    ///< no two at one position, none without a triangle
  std::vector<std::uint32_t> sharers;  ///< per vertex: other cells that use it, see sharer_bit
  std::vector<Triangle> triangles;
  /// Per vertex the sum of normals weighted by area, of this cell's triangles alone; empty where
  /// the input has normals, and once the vertices have theirs.
  std::vector<Vec3f> normal_sums;
  float error_m = 0, step_error_m = 0;  ///< as in Node
};

/// The bit of the neighbour at (di, dj, dk) cells from a cell, each -1, 0 or 1. A triangle is at
/// most half a cell long, so whoever shares a vertex with a cell touches it.
constexpr std::uint32_t sharer_bit(int di, int dj, int dk) {
  return std::uint32_t{1} << ((di + 1) + 3 * (dj + 1) + 9 * (dk + 1));
}
constexpr std::uint32_t sharer_bit(const CellKey& from, const CellKey& to) {
  return sharer_bit(to.i - from.i, to.j - from.j, to.k - from.k);
}

}  // namespace cornice::hlod
