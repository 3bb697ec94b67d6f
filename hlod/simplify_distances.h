// SPDX-License-Identifier: GPL-3.0-or-later
// Distances to triangles and between edges, eight at a time. Every distance is that to a point
// which was computed, so that rounding can make it too large but not too small.
#pragma once

#include <array>
#include <cstddef>

#include "core/base/vec.h"

namespace cornice::hlod {

inline constexpr std::size_t kDistanceLanes = 8;
using Lanes = std::array<float, kDistanceLanes>;

/// Triangles (0, next, prev) with a common corner at 0.
struct alignas(32) FanLanes {
  std::array<Lanes, 3> next, prev;
  /// Of measure_fan: products of the two sides and the inverses that divisions would take; 0 for
  /// those by zero.
  Lanes next_next, next_prev, prev_prev, per_area, per_next, per_prev, per_outer;
};
void measure_fan(FanLanes& fan);

/// Squared distances of a point to the triangles of a measured fan, and not 0 where the nearest
/// place lies on the side across from the common corner: beyond it there may be a nearer triangle.
/// Ericson 2005, "Real-Time Collision Detection", 5.1.5, all regions computed.
struct alignas(32) FanDistances {
  Lanes square;
  std::array<int, kDistanceLanes> is_beyond;
};
void distances_to_fan(const FanLanes& fan, Vec3f point, FanDistances& distances);

/// Pairs of segments: from a to b, and from p to q, which may be one point.
struct alignas(32) SegmentLanes {
  std::array<Lanes, 3> a, b, p, q;
};
/// Their distances; the a move to where their segments are nearest to the others. Ericson 2005,
/// 5.1.9.
void pass_over_segments(SegmentLanes& segments, Lanes& distances);

}  // namespace cornice::hlod
