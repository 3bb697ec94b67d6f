// SPDX-License-Identifier: GPL-3.0-or-later
// The open borders of the tiles of a survey: all that stitching has to look at.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice::stitch {

/// A vertex on an open border.
struct BorderVertex {
  Vec3d position;            ///< in the projected system
  std::uint32_t vertex = 0;  ///< in its tile
  std::uint32_t next = 0;    ///< index of the border vertex that follows, surface to the left
};

/// The borders of one tile.
struct TileBorder {
  Vec3d origin;
  std::vector<BorderVertex> vertices;
  std::vector<Vec3f> edge_normals;  ///< of the triangle at the edge to `next`
  std::uint64_t non_manifold_edges = 0;
};

TileBorder find_border(const Mesh& mesh, int threads);

/// What is wrong between finished tiles.
struct SeamReport {
  std::uint64_t shared_vertices = 0;  ///< border vertices that another tile has bit for bit
  std::uint64_t shared_edges = 0;     ///< border edges that another tile has the other way round
  std::uint64_t open_edges = 0;       ///< both ends shared with one tile, the edge not
  std::uint64_t t_vertices = 0;       ///< inside an open edge of another tile
  std::uint64_t mismatched_vertices = 0;  ///< within a centimetre of another tile's, not the same
  std::uint64_t non_manifold_edges = 0;   ///< in more than two triangles of all tiles
  std::uint64_t flipped_neighbours = 0;   ///< normals more than 90 degrees apart across a seam
};
SeamReport check_seams(const std::vector<TileBorder>& tiles);

}  // namespace cornice::stitch
