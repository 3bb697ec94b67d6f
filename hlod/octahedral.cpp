// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/octahedral.h"

#include <limits>

#include "core/base/clones.h"
#include "hlod/lanes.h"
#include "hlod/octahedral_lanes.h"

namespace cornice::hlod {
namespace {

struct Best {
  Float8 cosine;
  Int8 i, j;
};

CORNICE_INLINE void set_absolute(const Float8& value, Float8& to) {
  to = value < 0 ? -value : value;
}

/// The whole number at or below, of 0 to twice the limit.
CORNICE_INLINE void set_floor(const Float8& value, float limit, Int8& to) {
  const Float8 top = Float8{} + 2 * limit;
  Float8 kept = value > 0 ? value : Float8{};
  kept = kept < top ? kept : top;
  to = __builtin_convertvector(kept, Int8) - static_cast<std::int32_t>(limit);
}

CORNICE_INLINE void compare(const Float8& x, const Float8& y, const Float8& z, float step,
                            const Int8& i, const Int8& j, Best& best) {
  const Float8 u = __builtin_convertvector(i, Float8) * step;
  const Float8 v = __builtin_convertvector(j, Float8) * step;
  Float8 up, across, square;
  set_absolute(u, up), set_absolute(v, across);
  const Float8 pz = 1.0f - up - across;
  const Float8 fold = pz < 0 ? -pz : Float8{};
  const Float8 px = u + (u >= 0 ? -fold : fold), py = v + (v >= 0 ? -fold : fold);
  const Float8 along = px * x + py * y + pz * z;
  set_absolute(along, square);
  const Float8 cosine = along * square / (px * px + py * py + pz * pz);
  const Int8 is_nearer = cosine > best.cosine;
  best.cosine = is_nearer ? cosine : best.cosine;
  best.i = is_nearer ? i : best.i;
  best.j = is_nearer ? j : best.j;
}

}  // namespace

CORNICE_CLONES
void decode_octahedral(NormalLanes& lanes, int bits) {
  const float scale = 1.0f / static_cast<float>(octahedral_limit(bits));
  Int8 i, j;
  load_lanes(&lanes.i, i), load_lanes(&lanes.j, j);
  Float8 x = __builtin_convertvector(i, Float8) * scale;
  Float8 y = __builtin_convertvector(j, Float8) * scale;
  Float8 ax, ay;
  set_absolute(x, ax), set_absolute(y, ay);
  const Float8 z = 1.0f - ax - ay;
  const Float8 fold = z < 0 ? -z : Float8{};
  x += x >= 0 ? -fold : fold;
  y += y >= 0 ? -fold : fold;
  Float8 length = x * x + y * y + z * z;
  for (std::size_t k = 0; k < NormalLanes::kCount; ++k) length[k] = std::sqrt(length[k]);
  x /= length, y /= length;
  store_lanes(&lanes.x, x), store_lanes(&lanes.y, y), store_lanes(&lanes.z, z / length);
}

CORNICE_CLONES
void encode_octahedral(NormalLanes& lanes, int bits) {
  const std::int32_t limit = octahedral_limit(bits);
  const auto scale = static_cast<float>(limit);
  const float step = 1.0f / scale;
  Float8 x, y, z, ax, ay, az, au, av;
  load_lanes(&lanes.x, x), load_lanes(&lanes.y, y), load_lanes(&lanes.z, z);
  set_absolute(x, ax), set_absolute(y, ay), set_absolute(z, az);
  const Float8 sum = ax + ay + az, one = Float8{} + 1.0f;
  const Float8 part = 1.0f / (sum > 0 ? sum : one);
  const Float8 u = x * part, v = y * part;
  set_absolute(u, au), set_absolute(v, av);
  const Float8 low_u = (1.0f - av) * (u < 0 ? -one : one);
  const Float8 low_v = (1.0f - au) * (v < 0 ? -one : one);
  Int8 left, low;
  set_floor(((z < 0 ? low_u : u) + 1.0f) * scale, scale, left);
  set_floor(((z < 0 ? low_v : v) + 1.0f) * scale, scale, low);
  const Int8 most = Int8{} + limit;
  const Int8 right = left < most ? left + 1 : most, high = low < most ? low + 1 : most;
  Best best{Float8{} - std::numeric_limits<float>::infinity(), left, low};
  compare(x, y, z, step, left, low, best), compare(x, y, z, step, right, low, best);
  compare(x, y, z, step, left, high, best), compare(x, y, z, step, right, high, best);
  store_lanes(&lanes.i, best.i), store_lanes(&lanes.j, best.j);
}

}  // namespace cornice::hlod
