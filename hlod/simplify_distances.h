// SPDX-License-Identifier: GPL-3.0-or-later
// Distances to triangles and between edges, eight at a time. Every distance is that to a point
// which was computed, so that rounding can make it too large but not too small.
#pragma once

#include "core/base/vec.h"
#include "hlod/lanes.h"

namespace cornice::hlod {

struct alignas(32) VectorLanes {
  Float8 x, y, z;
};

CORNICE_INLINE void subtract(const VectorLanes& a, const VectorLanes& b, VectorLanes& to) {
  to.x = a.x - b.x, to.y = a.y - b.y, to.z = a.z - b.z;
}
CORNICE_INLINE void multiply(const VectorLanes& a, const VectorLanes& b, Float8& to) {
  to = a.x * b.x + a.y * b.y + a.z * b.z;
}
/// Of v - s * u.
CORNICE_INLINE void square_less(const VectorLanes& v, const Float8& s, const VectorLanes& u,
                                Float8& to) {
  const Float8 x = v.x - s * u.x, y = v.y - s * u.y, z = v.z - s * u.z;
  to = x * x + y * y + z * z;
}
CORNICE_INLINE void invert(Float8& value) {
  const Int8 positive = value > 0;
  const Float8 inverse = 1.0f / (positive ? value : Float8{} + 1.0f);
  value = positive ? inverse : Float8{};
}
CORNICE_INLINE void clamp_share(Float8& value) {
  value = value > 0 ? value : Float8{};
  value = value < 1 ? value : Float8{} + 1.0f;
}

/// Triangles (0, next, prev) with a common corner at 0.
struct alignas(32) FanLanes {
  VectorLanes next, prev;
  /// Of measure_fan: products of the two sides and the inverses that divisions would take; 0 for
  /// those by zero.
  Float8 next_next, next_prev, prev_prev, per_area, per_next, per_prev, per_outer;
};

CORNICE_INLINE void measure_fan(FanLanes& fan) {
  VectorLanes outer;
  subtract(fan.prev, fan.next, outer);
  Float8 nn, np, pp, per_outer;
  multiply(fan.next, fan.next, nn), multiply(fan.next, fan.prev, np);
  multiply(fan.prev, fan.prev, pp), multiply(outer, outer, per_outer);
  Float8 per_area = nn * pp - np * np;
  fan.next_next = nn, fan.next_prev = np, fan.prev_prev = pp;
  invert(per_area), invert(nn), invert(pp), invert(per_outer);
  fan.per_area = per_area, fan.per_next = nn, fan.per_prev = pp, fan.per_outer = per_outer;
}

/// Squared distances of a point to the triangles of a measured fan, and -1 where the nearest place
/// lies on the side across from the common corner: beyond it there may be a nearer triangle.
/// Ericson 2005, "Real-Time Collision Detection", 5.1.5, all regions computed.
CORNICE_INLINE void distances_to_fan(const FanLanes& fan, Vec3f point, Float8& square,
                                     Int8& is_beyond) {
  const VectorLanes w{Float8{} + point.x, Float8{} + point.y, Float8{} + point.z};
  const VectorLanes &n = fan.next, &p = fan.prev;
  Float8 wn, wp;
  multiply(w, n, wn), multiply(w, p, wp);
  // Within the triangle at s * n + t * p.
  const Float8 s = (fan.prev_prev * wn - fan.next_prev * wp) * fan.per_area;
  const Float8 t = (fan.next_next * wp - fan.next_prev * wn) * fan.per_area;
  const Int8 inside = (s >= 0) & (t >= 0) & (s + t <= 1) & (fan.per_area > 0);
  const VectorLanes rest{w.x - t * p.x, w.y - t * p.y, w.z - t * p.z};
  Float8 plane, along_next, along_prev, along_outer;
  square_less(rest, s, n, plane);
  Float8 place = wn * fan.per_next;
  clamp_share(place);
  square_less(w, place, n, along_next);
  place = wp * fan.per_prev;
  clamp_share(place);
  square_less(w, place, p, along_prev);
  VectorLanes outer, beyond_next;
  subtract(p, n, outer), subtract(w, n, beyond_next);
  multiply(beyond_next, outer, place);
  place *= fan.per_outer;
  clamp_share(place);
  square_less(beyond_next, place, outer, along_outer);
  const Float8 side = along_next < along_prev ? along_next : along_prev;
  is_beyond = ~inside & (along_outer < side);
  square = inside ? plane : is_beyond ? along_outer : side;
}

/// Squared distances between the segments from a to b and those from p to q, which may be one
/// point; the a move to where their segments are nearest to the others. Ericson 2005, 5.1.9.
CORNICE_INLINE void pass_over_segments(VectorLanes& a, const VectorLanes& b, const VectorLanes& p,
                                       const VectorLanes& q, Float8& square) {
  VectorLanes u, v, w;
  subtract(b, a, u), subtract(q, p, v), subtract(a, p, w);
  Float8 uu, vv, uv, uw, vw;
  multiply(u, u, uu), multiply(v, v, vv), multiply(u, v, uv), multiply(u, w, uw);
  multiply(v, w, vw);
  Float8 per_square = uu * vv - uv * uv, per_u = uu, per_v = vv;
  invert(per_square), invert(per_u), invert(per_v);
  Float8 s = (uv * vw - uw * vv) * per_square;
  clamp_share(s);
  Float8 t = (uv * s + vw) * per_v;
  clamp_share(t);
  s = (t * uv - uw) * per_u;
  clamp_share(s);
  const VectorLanes apart{w.x + s * u.x, w.y + s * u.y, w.z + s * u.z};
  a.x += s * u.x, a.y += s * u.y, a.z += s * u.z;
  square_less(apart, t, v, square);
}

}  // namespace cornice::hlod
