// SPDX-License-Identifier: GPL-3.0-or-later
// How far one surface lies from another.
#pragma once

#include <algorithm>
#include <vector>

#include "core/mesh/triangle_tree.h"

namespace cornice {

/// Appends points of a triangle about spacing_m apart: a barycentric lattice without the corners;
/// nothing where the longest edge is no longer than that.
void sample_triangle(Vec3f a, Vec3f b, Vec3f c, float spacing_m, std::vector<Vec3f>& samples);

/// Points of a surface to measure from: a copy of every position that a triangle names, then points
/// on the triangles whose longest edge exceeds `spacing_m`, about that far apart. Neighbours in the
/// list are near each other where `tree_order` (order() of a tree over the triangles) is given.
std::vector<Vec3f> sample_surface(const std::vector<Vec3f>& positions,
                                  const std::vector<Triangle>& triangles, float spacing_m,
                                  const std::vector<std::uint32_t>& tree_order);

/// Largest distance from any of the samples to the surface; 0 without samples, infinity where the
/// surface is empty. Samples that are known to be nearer than the largest so far are not measured
/// to the end, so this costs little more than looking at each. Exact for the samples given.
float largest_distance(const std::vector<Vec3f>& samples, const TriangleTree& surface, int threads);

/// Both directions, samples about spacing_m apart.
struct SurfaceDistance {
  float forth_m = 0.0f;  ///< from the first to the second
  float back_m = 0.0f;
  float hausdorff_m() const { return std::max(forth_m, back_m); }
};
SurfaceDistance measure_distance(const TriangleTree& first, const TriangleTree& second,
                                 float spacing_m, int threads);

}  // namespace cornice
