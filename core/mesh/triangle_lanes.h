// SPDX-License-Identifier: GPL-3.0-or-later
// Squared distances of one point from eight boxes or eight triangles at a time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cornice {

inline constexpr std::size_t kLanes = 8;

/// Corners of boxes, [axis][box]; a box whose low is infinite is none.
struct BoxLanes {
  float low[3][kLanes];
  float high[3][kLanes];
};

/// Corners of triangles, [corner][axis][triangle].
struct TriangleLanes {
  float corner[3][3][kLanes];
};

/// Sets bit k where box k is no farther than bound_sq, which is finite; writes all distances, right
/// to a few units in the last place.
std::uint32_t near_boxes(const BoxLanes& boxes, const float (&p)[3], float bound_sq,
                         float (&distance_sq)[kLanes]);

/// The same of triangles, in double precision: right to rounding of the square of their size, on
/// slivers and triangles without area too.
std::uint32_t near_triangles(const TriangleLanes& triangles, const float (&p)[3], double bound_sq,
                             double (&distance_sq)[kLanes]);

}  // namespace cornice
