// SPDX-License-Identifier: GPL-3.0-or-later
// What is wrong where tiles meet.
#pragma once

#include <cstdint>

#include "stages/stitch/border.h"
#include "stages/stitch/match.h"

namespace cornice::stitch {

/// Counts over a survey; all 0 where its tiles make one surface.
struct SeamReport {
  std::uint64_t open_edges = 0;  ///< that lie along another tile's border and do not match
  std::uint64_t t_vertices = 0;  ///< of such edges, inside another tile's edge
  std::uint64_t mismatched_vertices =
      0;  ///< of such edges, near another tile's vertex but not on it
  std::uint64_t non_manifold_edges = 0;  ///< inside tiles and across borders
  std::uint64_t turned_triangles = 0;    ///< pairs across a border that face opposite sides
  std::uint64_t degenerate_triangles = 0;
  std::uint64_t shared_edges = 0;  ///< that match: no fault

  std::uint64_t faults() const {
    return open_edges + t_vertices + mismatched_vertices + non_manifold_edges + turned_triangles +
           degenerate_triangles;
  }
};
SeamReport check_seams(const Borders& borders, const Matches& matches, double tolerance_m);

}  // namespace cornice::stitch
