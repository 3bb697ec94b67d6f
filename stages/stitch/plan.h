// SPDX-License-Identifier: GPL-3.0-or-later
// What becomes of the borders of a survey: which vertices become one, where, and which edges get
// new vertices.
//
//   tile A   a1────────a2──────────a3        b2 of tile B comes to lie on a2 (one class),
//   tile B   b1─────────b2────b4───b3        b4 is put into the edge a2-a3
#pragma once

#include <cstdint>
#include <vector>

#include "stages/stitch/border.h"
#include "stages/stitch/match.h"

namespace cornice::stitch {

/// A place on a tile's border: a vertex (a == b) or the point a + t (b - a) of an edge. Numbers of
/// all borders together.
struct Place {
  std::uint32_t tile = 0;
  std::uint32_t a = 0, b = 0;
  double t = 0.0;
  std::uint32_t edge = kNone;  ///< that gets a new vertex; kNone for a vertex that is there
};

/// Vertices that are to be one.
struct Plan {
  std::vector<std::uint32_t> first;  ///< of each class in `places`; one more at the end
  std::vector<Place> places;         ///< class by class, at least two of each; by tile, then vertex
  std::vector<Vec3d> positions;      ///< of each class, projected CRS
  std::vector<std::uint8_t> is_exact;  ///< 1 where all places of the class are there already
  std::uint64_t moved_vertices = 0;    ///< that did not lie where their class does
  std::uint64_t new_vertices = 0;      ///< put into edges
  std::uint64_t collapsed_edges = 0;
  double largest_move_m = 0.0;

  std::uint32_t class_count() const { return static_cast<std::uint32_t>(positions.size()); }
};

/// Tolerance of the joining of borders that do not match exactly.
struct JoinOptions {
  double tolerance_m = 0.25;
  double grid_m = 1.0 / 4096.0;  ///< new positions are multiples of it; a power of two
};

/// The plan for borders with `matches`: exact ones first, then the rest within the tolerance.
Plan plan_borders(const Borders& borders, const Matches& matches, const JoinOptions& options);

}  // namespace cornice::stitch
