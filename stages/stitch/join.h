// SPDX-License-Identifier: GPL-3.0-or-later
// Joins borders that should meet but do not, within a tolerance: the stitching of the reference,
// in space and for any number of tiles at once.
#pragma once

#include <cstdint>
#include <vector>

#include "stages/stitch/border.h"
#include "stages/stitch/match.h"

namespace cornice::stitch {

struct JoinOptions;

/// A vertex that another tile's edge gets, at from + t (to - from).
struct Insertion {
  std::uint32_t edge = kNone;
  double t = 0.0;
  std::uint32_t vertex = kNone;
};

/// Joins classes of vertices that are to be one, and says which edges get which vertices; sorted by
/// edge, then t. Only edges without a match take part.
std::vector<Insertion> join_loose_borders(const Borders& borders, const Matches& matches,
                                          const JoinOptions& options, Classes& classes);

}  // namespace cornice::stitch
