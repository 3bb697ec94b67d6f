// SPDX-License-Identifier: GPL-3.0-or-later
// The open borders of the tiles of a survey: all that stitching needs to know of a tile while it
// decides what becomes of its border.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/mesh.h"

namespace cornice::stitch {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// An edge with one triangle, which lies to its left seen from outside.
struct BorderEdge {
  std::uint32_t from = 0, to = 0;                ///< rows of Border::vertices
  std::uint32_t half_edge = 0;                   ///< 3 * triangle + corner, in the tile
  std::uint32_t previous = kNone, next = kNone;  ///< along the border; kNone where that is no fan
  Vec3f normal{};                                ///< unit, of the triangle; zero without area
  std::uint32_t part = 0;                        ///< of Border::part_areas_m2
  bool is_collapsible = false;  ///< its ends may become one vertex without spoiling the surface
};

/// What one tile has, and what is wrong inside it.
struct Border {
  Mesh vertices;                    ///< those of the border, with their attributes; no triangles
  std::vector<std::uint32_t> rows;  ///< of each of them: its row in the tile
  std::vector<BorderEdge> edges;
  Box3d box;  ///< of the whole tile, projected CRS; empty where it has no triangle
  std::vector<double> part_areas_m2;  ///< of each part of the tile that is connected over edges
  std::uint64_t tile_vertices = 0;
  std::uint64_t tile_triangles = 0;
  std::uint64_t non_manifold_edges = 0;
  std::uint64_t degenerate_triangles = 0;  ///< a vertex named twice, or no area

  Vec3d position(std::uint32_t vertex) const {
    return vertices.origin + vertices.positions[vertex].cast<double>();
  }
};

/// The border of a tile. Edges are listed by half-edge.
Border find_border(const Mesh& tile, int threads);

/// All borders of a survey with one numbering of their vertices and edges.
struct Borders {
  std::vector<Border> tiles;
  std::vector<std::uint32_t> first_vertex, first_edge;  ///< of each tile; one more at the end

  std::uint32_t vertex_count() const { return first_vertex.back(); }
  std::uint32_t edge_count() const { return first_edge.back(); }
  std::vector<Vec3d> positions() const;             ///< of all vertices
  std::vector<std::uint32_t> vertex_tiles() const;  ///< tile of each vertex
  std::vector<std::uint32_t> edge_tiles() const;
  std::vector<BorderEdge> edges() const;  ///< of all tiles, vertices and edges numbered alike
};
Borders number_borders(std::vector<Border> tiles);

/// Drops what no other tile comes near: edges whose box, grown by reach_m, meets the box of no
/// other tile. Their vertices go, too.
void keep_edges_near_tiles(std::vector<Border>& tiles, double reach_m);

}  // namespace cornice::stitch
