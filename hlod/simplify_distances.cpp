// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify_distances.h"

#include <cmath>

#include "core/base/clones.h"
#include "hlod/lanes.h"

namespace cornice::hlod {
namespace {

CORNICE_INLINE void load(Float8& to, const Lanes& from) { load_lanes(&from, to); }
CORNICE_INLINE void store(Lanes& to, const Float8& from) { store_lanes(&to, from); }

struct Vectors {
  Float8 x, y, z;
};
CORNICE_INLINE void load(Vectors& to, const std::array<Lanes, 3>& from) {
  load(to.x, from[0]), load(to.y, from[1]), load(to.z, from[2]);
}
CORNICE_INLINE void subtract(const Vectors& a, const Vectors& b, Vectors& to) {
  to.x = a.x - b.x, to.y = a.y - b.y, to.z = a.z - b.z;
}
CORNICE_INLINE void multiply(const Vectors& a, const Vectors& b, Float8& to) {
  to = a.x * b.x + a.y * b.y + a.z * b.z;
}
/// Of v - s * u.
CORNICE_INLINE void square_less(const Vectors& v, const Float8& s, const Vectors& u, Float8& to) {
  const Float8 x = v.x - s * u.x, y = v.y - s * u.y, z = v.z - s * u.z;
  to = x * x + y * y + z * z;
}
CORNICE_INLINE void invert(Float8& value) {
  const Int8 positive = value > 0;
  const Float8 inverse = 1.0f / (positive ? value : Float8{} + 1.0f);
  value = positive ? inverse : Float8{};
}
CORNICE_INLINE void clamp(Float8& value) {
  value = value > 0 ? value : Float8{};
  value = value < 1 ? value : Float8{} + 1.0f;
}

}  // namespace

CORNICE_CLONES
void measure_fan(FanLanes& fan) {
  Vectors n, p, outer;
  load(n, fan.next), load(p, fan.prev);
  subtract(p, n, outer);
  Float8 nn, np, pp, per_outer;
  multiply(n, n, nn), multiply(n, p, np), multiply(p, p, pp), multiply(outer, outer, per_outer);
  Float8 per_area = nn * pp - np * np;
  store(fan.next_next, nn), store(fan.next_prev, np), store(fan.prev_prev, pp);
  invert(per_area), invert(nn), invert(pp), invert(per_outer);
  store(fan.per_area, per_area), store(fan.per_next, nn), store(fan.per_prev, pp);
  store(fan.per_outer, per_outer);
}

CORNICE_CLONES
void distances_to_fan(const FanLanes& fan, Vec3f point, FanDistances& distances) {
  Vectors n, p, outer, beyond_next;
  const Vectors w{Float8{} + point.x, Float8{} + point.y, Float8{} + point.z};
  load(n, fan.next), load(p, fan.prev);
  Float8 nn, np, pp, per_area, per_next, per_prev, per_outer;
  load(nn, fan.next_next), load(np, fan.next_prev), load(pp, fan.prev_prev);
  load(per_area, fan.per_area), load(per_next, fan.per_next), load(per_prev, fan.per_prev);
  load(per_outer, fan.per_outer);
  Float8 wn, wp;
  multiply(w, n, wn), multiply(w, p, wp);
  // Within the triangle at s * n + t * p.
  const Float8 s = (pp * wn - np * wp) * per_area, t = (nn * wp - np * wn) * per_area;
  const Int8 inside = (s >= 0) & (t >= 0) & (s + t <= 1) & (per_area > 0);
  const Vectors rest{w.x - t * p.x, w.y - t * p.y, w.z - t * p.z};
  Float8 plane, along_next, along_prev, along_outer;
  square_less(rest, s, n, plane);
  Float8 place = wn * per_next;
  clamp(place);
  square_less(w, place, n, along_next);
  place = wp * per_prev;
  clamp(place);
  square_less(w, place, p, along_prev);
  subtract(p, n, outer), subtract(w, n, beyond_next);
  multiply(beyond_next, outer, place);
  place *= per_outer;
  clamp(place);
  square_less(beyond_next, place, outer, along_outer);
  const Float8 side = along_next < along_prev ? along_next : along_prev;
  const Int8 is_beyond = ~inside & (along_outer < side);
  store(distances.square, inside ? plane : is_beyond ? along_outer : side);
  store_lanes(&distances.is_beyond, is_beyond);
}

CORNICE_CLONES
void pass_over_segments(SegmentLanes& segments, Lanes& distances) {
  Vectors a, b, p, q, u, v, w;
  load(a, segments.a), load(b, segments.b), load(p, segments.p), load(q, segments.q);
  subtract(b, a, u), subtract(q, p, v), subtract(a, p, w);
  Float8 uu, vv, uv, uw, vw;
  multiply(u, u, uu), multiply(v, v, vv), multiply(u, v, uv), multiply(u, w, uw);
  multiply(v, w, vw);
  Float8 per_square = uu * vv - uv * uv, per_u = uu, per_v = vv;
  invert(per_square), invert(per_u), invert(per_v);
  Float8 s = (uv * vw - uw * vv) * per_square;
  clamp(s);
  Float8 t = (uv * s + vw) * per_v;
  clamp(t);
  s = (t * uv - uw) * per_u;
  clamp(s);
  const Vectors apart{w.x + s * u.x, w.y + s * u.y, w.z + s * u.z};
  store(segments.a[0], a.x + s * u.x), store(segments.a[1], a.y + s * u.y);
  store(segments.a[2], a.z + s * u.z);
  Float8 square;
  square_less(apart, t, v, square);
  alignas(32) Lanes squares;
  store(squares, square);
  for (std::size_t i = 0; i < kDistanceLanes; ++i) distances[i] = std::sqrt(squares[i]);
}

}  // namespace cornice::hlod
