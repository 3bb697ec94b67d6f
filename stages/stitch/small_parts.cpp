// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/small_parts.h"

#include <algorithm>

#include "core/mesh/topology.h"
#include "stages/stitch/match.h"

namespace cornice::stitch {

SmallParts find_small_parts(const Borders& borders, const Plan& plan, double min_area_m2) {
  std::vector<std::uint32_t> first_part{0};
  for (const Border& tile : borders.tiles) {
    first_part.push_back(first_part.back() + static_cast<std::uint32_t>(tile.part_areas_m2.size()));
  }
  Classes wholes(first_part.back());
  const std::vector<std::uint32_t> edge_tiles = borders.edge_tiles();
  const std::vector<BorderEdge> edges = borders.edges();
  const auto part_of = [&](std::uint32_t edge) {
    return first_part[edge_tiles[edge]] + edges[edge].part;
  };
  std::vector<std::uint32_t> vertex_part(borders.vertex_count(), kNone);
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    for (const std::uint32_t v : {edges[e].from, edges[e].to}) {
      if (vertex_part[v] == kNone) vertex_part[v] = part_of(e);
      wholes.join(vertex_part[v], part_of(e));  // two parts that touch in a vertex
    }
  }
  for (std::uint32_t c = 0; c < plan.class_count(); ++c) {
    std::uint32_t whole = kNone;
    for (std::uint32_t p = plan.first[c]; p < plan.first[c + 1]; ++p) {
      const Place& place = plan.places[p];
      const std::uint32_t part = place.edge == kNone ? vertex_part[place.a] : part_of(place.edge);
      if (whole == kNone) whole = part;
      wholes.join(whole, part);
    }
  }
  std::vector<double> areas(first_part.back(), 0.0);
  for (std::size_t t = 0; t < borders.tiles.size(); ++t) {
    const std::vector<double>& own = borders.tiles[t].part_areas_m2;
    for (std::uint32_t p = 0; p < own.size(); ++p) areas[wholes.find(first_part[t] + p)] += own[p];
  }
  SmallParts small;
  small.of_tile.resize(borders.tiles.size());
  for (std::size_t t = 0; t < borders.tiles.size(); ++t) {
    for (std::uint32_t p = first_part[t]; p < first_part[t + 1]; ++p) {
      const std::uint32_t whole = wholes.find(p);
      if (areas[whole] >= min_area_m2) continue;
      small.of_tile[t].push_back(p - first_part[t]);
      if (whole != p) continue;
      ++small.count;
      small.area_m2 += areas[whole];
    }
  }
  return small;
}

std::vector<std::uint32_t> triangles_of_parts(const Mesh& tile,
                                              const std::vector<std::uint32_t>& parts,
                                              int threads) {
  std::uint32_t count = 0;
  const std::vector<std::uint32_t> part_of = triangle_components(
      tile.triangles, match_half_edges(tile.triangles, tile.positions.size(), threads), count);
  std::vector<std::uint32_t> rows;
  for (std::uint32_t t = 0; t < part_of.size(); ++t) {
    if (std::binary_search(parts.begin(), parts.end(), part_of[t])) rows.push_back(t);
  }
  return rows;
}

}  // namespace cornice::stitch
