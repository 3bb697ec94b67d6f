// SPDX-License-Identifier: GPL-3.0-or-later
// A piece of a surface or of a cloud in a frame of its own, with what its shape says.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice::compare {

/// Triangles over vertices, or points alone. Positions are metres relative to `origin`, which lies
/// near, so that a float holds a tenth of a millimetre.
struct Surface {
  Vec3d origin;
  std::vector<Vec3f> positions;
  std::vector<Triangle> triangles;  ///< empty: a cloud
  std::vector<Vec3f> normals;       ///< of vertices; empty where not known
  std::vector<float> curvature;     ///< of vertices, 1/m, positive on crests; empty: not known

  std::size_t bytes() const {
    return sizeof(Vec3f) * (positions.size() + normals.size()) +
           sizeof(Triangle) * triangles.size() + sizeof(float) * curvature.size();
  }
};

/// Unit normals of vertices: the normals of the faces weighted by their angles there, so that the
/// sign of a distance is right at edges and corners too (Baerentzen, Aanaes 2005, "Signed distance
/// computation using the angle weighted pseudonormal"). Zero where a vertex is in no triangle.
std::vector<Vec3f> vertex_normals(const std::vector<Vec3f>& positions,
                                  const std::vector<Triangle>& triangles);

/// Mean curvature of vertices in 1/m, positive where the surface bulges outwards: the mean over the
/// edges of (n_j - n_i) (p_j - p_i) / |p_j - p_i|^2, each edge of a triangle counted once for it.
std::vector<float> vertex_curvature(const Surface& surface);

/// Joins open-edge vertices of different pieces that lie within `tolerance_m` of each other.
/// `piece` has the number of the file that each vertex is from.
void weld_borders(Surface& surface, const std::vector<std::uint32_t>& piece, float tolerance_m,
                  int threads);

}  // namespace cornice::compare
