// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/seams.h"

#include <algorithm>
#include <set>

#include "stages/stitch/edge_grid.h"
#include "stages/stitch/near_vertices.h"

namespace cornice::stitch {
namespace {

/// Cosine between two triangles of an edge that lie on each other, folded, rather than along each
/// other: a lip of rock is rarely sharper than 18 degrees.
constexpr double kFolded = -0.95;

/// Whether the middle of a loose edge lies along another tile's loose border.
bool lies_along_another(const LooseBorders& loose, std::uint32_t e) {
  const BorderEdge& edge = loose.edges()[e];
  const Vec3d along = loose.along(e);
  const Vec3d middle = loose.positions()[edge.from] + along * 0.5;
  return !loose
              .edges_near(middle, along, along, edge.normal.cast<double>(), norm(along),
                          loose.tile_of(edge.from))
              .empty();
}

}  // namespace

SeamReport check_seams(const Borders& borders, const Matches& matches, double tolerance_m) {
  SeamReport report;
  for (const Border& tile : borders.tiles) {
    report.non_manifold_edges += tile.non_manifold_edges;
    report.degenerate_triangles += tile.degenerate_triangles;
  }
  report.non_manifold_edges += matches.non_manifold_edges;
  report.turned_triangles = matches.turned_edges;
  const LooseBorders loose(borders, matches, tolerance_m);
  for (std::uint32_t e = 0; e < loose.edges().size(); ++e) {
    const std::uint32_t other = matches.partner[e];
    if (other == kNone || other < e) continue;
    ++report.shared_edges;
    report.turned_triangles += dot(loose.edges()[e].normal, loose.edges()[other].normal) < kFolded;
  }
  std::set<std::uint32_t> suspects;
  for (const std::uint32_t e : loose.loose_edges()) {
    if (!lies_along_another(loose, e)) continue;
    ++report.open_edges;
    suspects.insert({loose.edges()[e].from, loose.edges()[e].to});
  }
  const auto nearest = nearest_vertices(loose, tolerance_m);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const std::uint32_t v = loose.loose_vertices()[i];
    if (!suspects.contains(v)) continue;
    report.t_vertices += !loose.edges_near(v).empty();
    report.mismatched_vertices += std::any_of(
        nearest[i].begin(), nearest[i].end(),
        [&](const auto& other) { return loose.positions()[other.second] != loose.positions()[v]; });
  }
  return report;
}

}  // namespace cornice::stitch
