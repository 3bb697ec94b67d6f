// SPDX-License-Identifier: GPL-3.0-or-later
// Which border edges of different tiles are one and the same edge, bit for bit.
#pragma once

#include <cstdint>
#include <vector>

#include "stages/stitch/border.h"

namespace cornice::stitch {

/// Numbers below are those of all borders together.
struct Matches {
  std::vector<std::uint32_t> partner;    ///< of each edge: the same edge of another tile, or kNone
  std::uint64_t non_manifold_edges = 0;  ///< more than two tiles or parts have them
  std::uint64_t turned_edges = 0;        ///< two tiles have them in the same direction
};
/// Edges match where their ends are equal in the projected CRS and they run in opposite directions.
Matches match_edges(const Borders& borders);

/// Classes of things that are one and the same; the least member stands for all.
class Classes {
 public:
  explicit Classes(std::uint32_t count);
  std::uint32_t find(std::uint32_t member) const;
  void join(std::uint32_t a, std::uint32_t b);

 private:
  mutable std::vector<std::uint32_t> parent_;
};

/// Vertices that are ends of matching edges, class by class. Two parts of the surface that touch in
/// a point only stay two: their vertices are not joined.
Classes join_matches(const Borders& borders, const Matches& matches);

}  // namespace cornice::stitch
