// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/seams.h"

#include <algorithm>
#include <vector>

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
  // A second place, because the other side may have a vertex right at the middle.
  for (const double share : {0.5, 0.4}) {
    const Vec3d place = loose.positions()[edge.from] + along * share;
    if (!loose
             .edges_near(place, along, along, edge.normal.cast<double>(), norm(along),
                         loose.tile_of(edge.from))
             .empty()) {
      return true;
    }
  }
  return false;
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
  const auto nearest = nearest_vertices(loose, tolerance_m);
  std::vector<std::uint8_t> is_near(borders.vertex_count(), 0), is_suspect(is_near);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const std::uint32_t v = loose.loose_vertices()[i];
    is_near[v] = !nearest[i].empty() || !loose.edges_near(v).empty();
  }
  for (const std::uint32_t e : loose.loose_edges()) {
    // Where a hole ends at a shared border its two sides part: one end and the middle are near.
    const BorderEdge& edge = loose.edges()[e];
    if (is_near[edge.from] == 0 || is_near[edge.to] == 0 || !lies_along_another(loose, e)) continue;
    ++report.open_edges;
    is_suspect[edge.from] = is_suspect[edge.to] = 1;
  }
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const std::uint32_t v = loose.loose_vertices()[i];
    if (is_suspect[v] == 0) continue;
    const auto is_apart = [&](const auto& other) {
      return loose.positions()[other.second] != loose.positions()[v];
    };
    if (nearest[i].empty()) {
      ++report.t_vertices;
    } else {
      report.mismatched_vertices += std::any_of(nearest[i].begin(), nearest[i].end(), is_apart);
    }
  }
  return report;
}

}  // namespace cornice::stitch
