// SPDX-License-Identifier: GPL-3.0-or-later
// A survey solved tile by tile, joined, and compared with the same points solved in one piece.
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/mesh.h"

namespace cornice::bench {

struct TilingOptions {
  double step_m = 0.5;
  double halo_m = 40.0;
  double band_m = 8.0;
  double near_m = 10.0;     ///< of an inner border: what counts as seam
  double measured_m = 0.5;  ///< from a measured point: surface that counts
  int threads = 2;
};

struct SeamReport {
  std::size_t triangles = 0;
  std::size_t open_edges = 0;    ///< away from the outline of the survey and its holes
  std::size_t mismatched = 0;    ///< vertices on an inner border that one side alone has
  std::size_t turned = 0;        ///< vertices whose normals differ by any bit between the sides
  std::size_t non_manifold = 0;  ///< edges and vertices
  double rms_m = 0.0;            ///< of measured seam vertices, from the mesh in one piece
  double largest_m = 0.0;
  double rms_anywhere_m = 0.0;  ///< of all measured vertices
  Mesh joined;
};

/// Solves each tile on its points and halo, extracts it with the bands of the others, and joins.
SeamReport measure_seams(const OrientedPoints& points, const std::vector<Box2d>& tiles,
                         const TilingOptions& options);

/// Boxes of the points of tiles that lie beside each other, which the points fill nearly: sides
/// that face each other are moved onto one line between them.
std::vector<Box2d> side_by_side(std::vector<Box2d> boxes, double step_m);

}  // namespace cornice::bench
