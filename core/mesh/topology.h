// SPDX-License-Identifier: GPL-3.0-or-later
// How the triangles of a mesh hang together.
//
//            c
//          /   \          triangle t = (a, b, c) has the half-edges
//    3t+2 /     \ 3t+1    3t (a to b), 3t+1 (b to c), 3t+2 (c to a)
//        /       \        .
//       a ------- b
//           3t
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"

namespace cornice {

using Triangle = std::array<std::uint32_t, 3>;

/// What a half-edge has instead of a twin: an open border, or an edge that does not belong to
/// exactly two triangles that run along it in opposite directions.
inline constexpr std::uint32_t kOpenEdge = 0xffffffffu;
inline constexpr std::uint32_t kNonManifoldEdge = 0xfffffffeu;
inline constexpr std::uint32_t kNoTwin = kNonManifoldEdge;  ///< from here on: no twin

inline std::uint32_t next_half_edge(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline std::uint32_t previous_half_edge(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// The twin of each of the 3 * #T half-edges, kOpenEdge or kNonManifoldEdge. Half-edges of
/// triangles that name a vertex twice are kNonManifoldEdge. Memory: 24 bytes a triangle while it
/// runs.
std::vector<std::uint32_t> match_half_edges(const std::vector<Triangle>& triangles,
                                            std::size_t vertex_count, int threads);

/// One byte per vertex: 1 where an open or non-manifold edge ends, or where the triangles around
/// the vertex are more than one fan (the surface touches itself there in a point). `bad_vertices`,
/// where given, gets those alone that are no manifold: more than one fan, or a non-manifold edge.
std::vector<std::uint8_t> border_vertices(const std::vector<Triangle>& triangles,
                                          const std::vector<std::uint32_t>& twins,
                                          std::size_t vertex_count,
                                          std::vector<std::uint8_t>* bad_vertices = nullptr);

/// Counts of what a mesh should not have, and of open edges.
struct TopologyReport {
  std::uint64_t open_edges = 0;
  std::uint64_t non_manifold_edges = 0;     ///< more than two triangles, or two of one direction
  std::uint64_t non_manifold_vertices = 0;  ///< more than one fan of triangles
  std::uint64_t degenerate_triangles = 0;   ///< a vertex named twice
  std::uint64_t duplicate_triangles = 0;    ///< beyond the first of the same three vertices
  std::uint64_t isolated_vertices = 0;      ///< in no triangle
  std::uint64_t components = 0;             ///< parts connected over edges

  bool is_manifold() const {
    return non_manifold_edges == 0 && non_manifold_vertices == 0 && degenerate_triangles == 0 &&
           duplicate_triangles == 0;
  }
};
TopologyReport check_topology(const std::vector<Triangle>& triangles, std::size_t vertex_count,
                              int threads);

/// Open edges in order: each loop lists vertices, the surface to the left seen from outside; the
/// last is joined to the first. Where borders touch in a vertex the loop goes through it.
std::vector<std::vector<std::uint32_t>> border_loops(const std::vector<Triangle>& triangles,
                                                     const std::vector<std::uint32_t>& twins,
                                                     std::size_t vertex_count);

/// Component of each triangle, numbered from 0 by first triangle; triangles are connected over
/// edges that have a twin. `count` gets how many there are.
std::vector<std::uint32_t> triangle_components(const std::vector<Triangle>& triangles,
                                               const std::vector<std::uint32_t>& twins,
                                               std::uint32_t& count);

}  // namespace cornice
