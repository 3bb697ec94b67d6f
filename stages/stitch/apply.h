// SPDX-License-Identifier: GPL-3.0-or-later
// Carries out what was planned for one tile, and mends the triangles that suffer by it.
#pragma once

#include "stages/stitch/resolve.h"

namespace cornice::stitch {

struct ApplyCounts {
  std::uint64_t dropped_triangles = 0;  ///< without area after their border edge collapsed
  std::uint64_t turned_edges = 0;       ///< to mend thin or folded triangles
};

/// Moves, collapses and inserts border vertices; new ones get attributes from the ends of their
/// edge. Then turns edges of thin (below 10 degrees) and folded triangles that have changed, where
/// that makes the worse of the two better.
ApplyCounts apply_plan(Mesh& mesh, const TilePlan& plan, int threads);

}  // namespace cornice::stitch
