// SPDX-License-Identifier: GPL-3.0-or-later
// Where the border vertices of neighbouring tiles go, so that they are the same.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "stages/stitch/borders.h"

namespace cornice::stitch {

struct Options {
  double reach_m = 1.0;      ///< border vertices farther apart are no neighbours
  double collapse_m = 0.25;  ///< a vertex between matched ones moves onto one as near as this
  int threads = 0;
};

/// What to do with one tile, in the numbers of its own vertices.
struct TilePlan {
  std::map<std::uint32_t, Vec3d> move;
  std::map<std::uint32_t, std::uint32_t> collapse;  ///< vertex, onto which
  /// Vertices to put on the border edge from the first to the second, in order.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Vec3d>> insert;

  bool empty() const { return move.empty() && collapse.empty() && insert.empty(); }
};

struct Plan {
  std::vector<TilePlan> tiles;
  std::uint64_t exact_vertices = 0;  ///< border vertices that were the same already
  std::uint64_t corners = 0;         ///< places where three or more tiles were brought together
  std::uint64_t projected = 0;       ///< moved onto a vertex of another tile
  std::uint64_t collapsed = 0;
  std::uint64_t inserted = 0;
};

/// Exact matches stay. Where a pair of tiles has none or few, its border vertices are put onto the
/// nearest ones of the tile that comes first (corners of more than two tiles before all else), and
/// vertices that lie between two matched ones collapse onto the nearest of them or are inserted on
/// the other side. New places are multiples of 1/1024 m, which floats relative to any tile's origin
/// hold without rounding (origins on whole 1/1024 m; extents below 8 km).
Plan resolve(const std::vector<TileBorder>& tiles, const Options& options);

}  // namespace cornice::stitch
