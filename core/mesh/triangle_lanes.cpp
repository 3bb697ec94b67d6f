// SPDX-License-Identifier: GPL-3.0-or-later
// Without branches: each loop below is one vector instruction a line, four or two triangles each.
// The places on the three edges and on the plane come from five dot products; the nearest is
// chosen by differences that lose digits, then its distance is taken anew from its coordinates.
#include "core/mesh/triangle_lanes.h"

#include "core/base/clones.h"

namespace cornice {
namespace {

// The order of operands is that of the instructions: the second where either is not a number.
template <class T>
inline T larger(T a, T b) {
  return a > b ? a : b;
}
template <class T>
inline T smaller(T a, T b) {
  return a < b ? a : b;
}
inline double clamp_unit(double x) { return smaller(larger(x, 0.0), 1.0); }

/// Added to what is divided by: edges without length and triangles without area divide zero by it.
constexpr double kTiny = 1e-300;

/// Bit k where square[k] is no larger than the bound; all of them go to `distance_sq`, which may be
/// anywhere, so the loops before this one fill an array of their own.
template <class T>
inline std::uint32_t keep_near(const T (&square)[kLanes], T bound_sq, T (&distance_sq)[kLanes]) {
  std::uint32_t mask = 0;
  for (std::size_t k = 0; k < kLanes; ++k) {
    mask |= square[k] <= bound_sq ? std::uint32_t{1} << k : 0;
    distance_sq[k] = square[k];
  }
  return mask;
}

}  // namespace

CORNICE_WIDE_CLONES std::uint32_t near_boxes(const BoxLanes& boxes, const float (&p)[3],
                                             float bound_sq, float (&distance_sq)[kLanes]) {
  float square[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) {
    const float x = larger(larger(boxes.low[0][k] - p[0], p[0] - boxes.high[0][k]), 0.0f);
    const float y = larger(larger(boxes.low[1][k] - p[1], p[1] - boxes.high[1][k]), 0.0f);
    const float z = larger(larger(boxes.low[2][k] - p[2], p[2] - boxes.high[2][k]), 0.0f);
    square[k] = x * x + y * y + z * z;
  }
  return keep_near(square, bound_sq, distance_sq);
}

CORNICE_WIDE_CLONES std::uint32_t near_triangles(const TriangleLanes& triangles,
                                                 const float (&p)[3], double bound_sq,
                                                 double (&distance_sq)[kLanes]) {
  const double at[3] = {static_cast<double>(p[0]), static_cast<double>(p[1]),
                        static_cast<double>(p[2])};
  // Apart, or the loop below takes eight at once for the floats' sake and runs out of registers.
  double all_ab[3][kLanes], all_ac[3][kLanes], all_ap[3][kLanes];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const auto a = static_cast<double>(triangles.corner[0][axis][k]);
      all_ab[axis][k] = static_cast<double>(triangles.corner[1][axis][k]) - a;
      all_ac[axis][k] = static_cast<double>(triangles.corner[2][axis][k]) - a;
      all_ap[axis][k] = at[axis] - a;
    }
  }
  double square[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) {
    const double ab[3] = {all_ab[0][k], all_ab[1][k], all_ab[2][k]};
    const double ac[3] = {all_ac[0][k], all_ac[1][k], all_ac[2][k]};
    const double ap[3] = {all_ap[0][k], all_ap[1][k], all_ap[2][k]};
    const double bb = ab[0] * ab[0] + ab[1] * ab[1] + ab[2] * ab[2];
    const double cc = ac[0] * ac[0] + ac[1] * ac[1] + ac[2] * ac[2];
    const double bc = ab[0] * ac[0] + ab[1] * ac[1] + ab[2] * ac[2];
    const double bp = ab[0] * ap[0] + ab[1] * ap[1] + ab[2] * ap[2];
    const double cp = ac[0] * ap[0] + ac[1] * ap[1] + ac[2] * ap[2];
    // Along b to c, and its length.
    const double ep = cp - bp - bc + bb;
    const double ee = larger(bb + cc - 2.0 * bc, 0.0);
    const double along_b = clamp_unit(bp / (bb + kTiny));
    const double along_c = clamp_unit(cp / (cc + kTiny));
    const double along_e = clamp_unit(ep / (ee + kTiny));
    // By how much each place is nearer than corner a.
    const double gain_b = along_b * (along_b * bb - 2.0 * bp);
    const double gain_c = along_c * (along_c * cc - 2.0 * cp);
    const double gain_e = bb - 2.0 * bp + along_e * (along_e * ee - 2.0 * ep);
    double u = gain_c < gain_b ? 0.0 : along_b;
    double v = gain_c < gain_b ? along_c : 0.0;
    double gain = smaller(gain_c, gain_b);
    u = gain_e < gain ? 1.0 - along_e : u;
    v = gain_e < gain ? along_e : v;
    gain = smaller(gain_e, gain);
    const double area = bb * cc - bc * bc;
    const double area_u = cc * bp - bc * cp;
    const double area_v = bb * cp - bc * bp;
    const double least = smaller(smaller(area_u, area_v), area - area_u - area_v);
    const double per_area = 1.0 / (larger(area, 0.0) + kTiny);
    const double in_u = least > 0.0 ? area_u * per_area : u;
    const double in_v = least > 0.0 ? area_v * per_area : v;
    // On a sliver these two may be far off along it; an edge is nearer then.
    const double gain_in =
        in_u * (in_u * bb - 2.0 * bp) + in_v * (in_v * cc - 2.0 * cp) + 2.0 * in_u * in_v * bc;
    u = gain_in < gain ? in_u : u;
    v = gain_in < gain ? in_v : v;
    const double x = ap[0] - u * ab[0] - v * ac[0];
    const double y = ap[1] - u * ab[1] - v * ac[1];
    const double z = ap[2] - u * ab[2] - v * ac[2];
    square[k] = x * x + y * y + z * z;
  }
  return keep_near(square, bound_sq, distance_sq);
}

}  // namespace cornice
