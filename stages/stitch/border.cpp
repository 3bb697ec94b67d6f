// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/border.h"

#include <algorithm>
#include <limits>

#include "core/base/error.h"
#include "core/mesh/select.h"
#include "core/mesh/topology.h"

namespace cornice::stitch {
namespace {

/// The half-edges of a mesh and their twins.
struct Links {
  const std::vector<Triangle>& triangles;
  std::vector<std::uint32_t> twins;

  std::uint32_t start(std::uint32_t h) const { return triangles[h / 3][h % 3]; }
  std::uint32_t end(std::uint32_t h) const { return start(next_half_edge(h)); }

  /// The open edge that follows an open edge round the vertex at its end; kNone where the fan there
  /// ends in a non-manifold edge.
  std::uint32_t next_open(std::uint32_t h) const {
    std::uint32_t turn = next_half_edge(h);
    while (twins[turn] < kNoTwin) turn = next_half_edge(twins[turn]);
    return twins[turn] == kOpenEdge ? turn : kNone;
  }

  /// Neighbours of the start of open edge h, over its fan.
  std::vector<std::uint32_t> around_start(std::uint32_t h) const {
    std::vector<std::uint32_t> found{end(h)};
    for (;;) {
      const std::uint32_t before = previous_half_edge(h);
      found.push_back(start(before));
      if (twins[before] >= kNoTwin) return found;
      h = twins[before];
    }
  }
  /// Neighbours of the end of open edge h, over its fan.
  std::vector<std::uint32_t> around_end(std::uint32_t h) const {
    std::vector<std::uint32_t> found{start(h)};
    for (std::uint32_t turn = next_half_edge(h);; turn = next_half_edge(twins[turn])) {
      found.push_back(end(turn));
      if (twins[turn] >= kNoTwin) return found;
    }
  }
};

/// Dey, Edelsbrunner et al. 1999, "Topology preserving edge contraction": the ends of an open edge
/// may become one where they have one neighbour in common, the apex of its triangle. A triangle
/// with two open edges is kept, or its third edge would be left without surface on one side.
bool can_collapse(const Links& links, std::uint32_t h) {
  if (links.twins[next_half_edge(h)] >= kNoTwin || links.twins[previous_half_edge(h)] >= kNoTwin) {
    return false;
  }
  std::vector<std::uint32_t> a = links.around_start(h), b = links.around_end(h);
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  std::vector<std::uint32_t> common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return common.size() == 1;
}

Vec3f unit_normal(const Mesh& tile, const Triangle& t) {
  const Vec3d a = tile.positions[t[0]].cast<double>();
  return normalized(cross(tile.positions[t[1]].cast<double>() - a,
                          tile.positions[t[2]].cast<double>() - a))
      .cast<float>();
}

void count_faults(const Mesh& tile, const Links& links, Border& border) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> bad;
  for (std::uint32_t t = 0; t < tile.triangles.size(); ++t) {
    const Triangle& c = tile.triangles[t];
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0] || triangle_area(tile, c) <= 0.0) {
      ++border.degenerate_triangles;
    }
    for (const std::uint32_t v : c) {
      border.box.add(tile.origin + tile.positions[v].cast<double>());
    }
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      if (links.twins[h] == kNonManifoldEdge && links.start(h) != links.end(h)) {
        bad.push_back(std::minmax(links.start(h), links.end(h)));
      }
    }
  }
  std::sort(bad.begin(), bad.end());
  border.non_manifold_edges =
      static_cast<std::uint64_t>(std::unique(bad.begin(), bad.end()) - bad.begin());
}

/// Returns the part of each triangle.
std::vector<std::uint32_t> measure_parts(const Mesh& tile, const Links& links, Border& border) {
  std::uint32_t count = 0;
  std::vector<std::uint32_t> part_of = triangle_components(tile.triangles, links.twins, count);
  border.part_areas_m2.assign(count, 0.0);
  for (std::size_t t = 0; t < part_of.size(); ++t) {
    border.part_areas_m2[part_of[t]] += triangle_area(tile, tile.triangles[t]);
  }
  return part_of;
}

/// Keeps the edges whose byte is not 0, and the vertices that they name.
void keep_edges(Border& border, const std::vector<std::uint8_t>& keep) {
  std::vector<std::uint32_t> edge_to(border.edges.size(), kNone);
  std::vector<std::uint32_t> vertex_to(border.rows.size(), kNone), kept_vertices, rows;
  std::vector<BorderEdge> edges;
  for (std::uint32_t e = 0; e < border.edges.size(); ++e) {
    if (keep[e] == 0) continue;
    edge_to[e] = static_cast<std::uint32_t>(edges.size());
    edges.push_back(border.edges[e]);
    vertex_to[border.edges[e].from] = vertex_to[border.edges[e].to] = 0;
  }
  for (std::uint32_t v = 0; v < vertex_to.size(); ++v) {
    if (vertex_to[v] == kNone) continue;
    vertex_to[v] = static_cast<std::uint32_t>(kept_vertices.size());
    kept_vertices.push_back(v);
    rows.push_back(border.rows[v]);
  }
  for (BorderEdge& edge : edges) {
    edge.from = vertex_to[edge.from];
    edge.to = vertex_to[edge.to];
    if (edge.previous != kNone) edge.previous = edge_to[edge.previous];
    if (edge.next != kNone) edge.next = edge_to[edge.next];
  }
  border.vertices = gather_vertices(border.vertices, kept_vertices);
  border.rows = std::move(rows);
  border.edges = std::move(edges);
}

}  // namespace

Border find_border(const Mesh& tile, int threads) {
  const Links links{tile.triangles,
                    match_half_edges(tile.triangles, tile.positions.size(), threads)};
  Border border;
  border.tile_vertices = tile.positions.size();
  border.tile_triangles = tile.triangles.size();
  count_faults(tile, links, border);
  const std::vector<std::uint32_t> part_of = measure_parts(tile, links, border);
  std::vector<std::uint32_t> open;
  std::vector<std::uint32_t> vertex_of(tile.positions.size(), kNone);
  std::vector<std::uint32_t> edge_of(links.twins.size(), kNone);
  for (std::uint32_t h = 0; h < links.twins.size(); ++h) {
    if (links.twins[h] != kOpenEdge) continue;
    edge_of[h] = static_cast<std::uint32_t>(open.size());
    open.push_back(h);
    vertex_of[links.start(h)] = vertex_of[links.end(h)] = 0;
  }
  for (std::uint32_t v = 0; v < vertex_of.size(); ++v) {
    if (vertex_of[v] == kNone) continue;
    vertex_of[v] = static_cast<std::uint32_t>(border.rows.size());
    border.rows.push_back(v);
  }
  border.vertices = gather_vertices(tile, border.rows);
  border.edges.resize(open.size());
  for (std::uint32_t e = 0; e < open.size(); ++e) {
    BorderEdge& edge = border.edges[e];
    const std::uint32_t h = open[e];
    edge.from = vertex_of[links.start(h)];
    edge.to = vertex_of[links.end(h)];
    edge.half_edge = h;
    edge.normal = unit_normal(tile, tile.triangles[h / 3]);
    edge.part = part_of[h / 3];
    edge.is_collapsible = can_collapse(links, h);
    const std::uint32_t next = links.next_open(h);
    if (next == kNone) continue;
    edge.next = edge_of[next];
    border.edges[edge.next].previous = e;
  }
  return border;
}

Borders number_borders(std::vector<Border> tiles) {
  Borders borders;
  borders.tiles = std::move(tiles);
  borders.first_vertex.assign(1, 0);
  borders.first_edge.assign(1, 0);
  std::uint64_t vertices = 0, edges = 0;
  for (const Border& tile : borders.tiles) {
    vertices += tile.rows.size();
    edges += tile.edges.size();
    if (std::max(vertices, edges) >= kNone) {
      throw RunError("", "the borders of all tiles have more than 2^32 vertices; stitch in parts");
    }
    borders.first_vertex.push_back(static_cast<std::uint32_t>(vertices));
    borders.first_edge.push_back(static_cast<std::uint32_t>(edges));
  }
  return borders;
}

std::vector<Vec3d> Borders::positions() const {
  std::vector<Vec3d> all;
  all.reserve(vertex_count());
  for (const Border& tile : tiles) {
    for (std::uint32_t v = 0; v < tile.rows.size(); ++v) all.push_back(tile.position(v));
  }
  return all;
}

std::vector<std::uint32_t> Borders::vertex_tiles() const {
  std::vector<std::uint32_t> all;
  all.reserve(vertex_count());
  for (std::uint32_t t = 0; t < tiles.size(); ++t) all.insert(all.end(), tiles[t].rows.size(), t);
  return all;
}

std::vector<std::uint32_t> Borders::edge_tiles() const {
  std::vector<std::uint32_t> all;
  all.reserve(edge_count());
  for (std::uint32_t t = 0; t < tiles.size(); ++t) all.insert(all.end(), tiles[t].edges.size(), t);
  return all;
}

std::vector<BorderEdge> Borders::edges() const {
  std::vector<BorderEdge> all;
  all.reserve(edge_count());
  for (std::uint32_t t = 0; t < tiles.size(); ++t) {
    for (BorderEdge edge : tiles[t].edges) {
      edge.from += first_vertex[t];
      edge.to += first_vertex[t];
      if (edge.previous != kNone) edge.previous += first_edge[t];
      if (edge.next != kNone) edge.next += first_edge[t];
      all.push_back(edge);
    }
  }
  return all;
}

void keep_edges_near_tiles(std::vector<Border>& tiles, double reach_m) {
  const auto grown = [&](Box3d box) {
    const Vec3d by{reach_m, reach_m, reach_m};
    box.min -= by;
    box.max += by;
    return box;
  };
  const auto meets = [](const Box3d& a, const Box3d& b) {
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
           a.min.z <= b.max.z && b.min.z <= a.max.z;
  };
  std::vector<Box3d> boxes;
  for (const Border& tile : tiles) boxes.push_back(tile.box);
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    std::vector<Box3d> near;
    if (!boxes[t].empty()) {
      for (std::size_t o = 0; o < boxes.size(); ++o) {
        if (o != t && !boxes[o].empty() && meets(grown(boxes[t]), boxes[o]))
          near.push_back(boxes[o]);
      }
    }
    std::vector<std::uint8_t> keep(tiles[t].edges.size(), 0);
    for (std::size_t e = 0; e < keep.size(); ++e) {
      Box3d box;
      box.add(tiles[t].position(tiles[t].edges[e].from));
      box.add(tiles[t].position(tiles[t].edges[e].to));
      box = grown(box);
      keep[e] = std::any_of(near.begin(), near.end(),
                            [&](const Box3d& other) { return meets(box, other); });
    }
    keep_edges(tiles[t], keep);
  }
}

}  // namespace cornice::stitch
