// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/octahedral.h"

#include <cstring>

#include "core/base/clones.h"
#include "hlod/octahedral_lanes.h"

namespace cornice::hlod {
namespace {

using Floats [[gnu::vector_size(32)]] = float;
using Words [[gnu::vector_size(32)]] = std::int32_t;

struct Best {
  Floats cosine;
  Words i, j;
};

[[gnu::always_inline]] inline void set_absolute(const Floats& value, Floats& to) {
  to = value < 0 ? -value : value;
}

/// The whole number at or below, of 0 to twice the limit.
[[gnu::always_inline]] inline void set_floor(const Floats& value, float limit, Words& to) {
  const Floats top = Floats{} + 2 * limit;
  Floats kept = value > 0 ? value : Floats{};
  kept = kept < top ? kept : top;
  to = __builtin_convertvector(kept, Words) - static_cast<std::int32_t>(limit);
}

[[gnu::always_inline]] inline void compare(const Floats& x, const Floats& y, const Floats& z,
                                           float step, const Words& i, const Words& j, Best& best) {
  const Floats u = __builtin_convertvector(i, Floats) * step;
  const Floats v = __builtin_convertvector(j, Floats) * step;
  Floats up, across, square;
  set_absolute(u, up), set_absolute(v, across);
  const Floats pz = 1.0f - up - across;
  const Floats fold = pz < 0 ? -pz : Floats{};
  const Floats px = u + (u >= 0 ? -fold : fold), py = v + (v >= 0 ? -fold : fold);
  const Floats along = px * x + py * y + pz * z;
  set_absolute(along, square);
  const Floats cosine = along * square / (px * px + py * py + pz * pz);
  const Words is_nearer = cosine > best.cosine;
  best.cosine = is_nearer ? cosine : best.cosine;
  best.i = is_nearer ? i : best.i;
  best.j = is_nearer ? j : best.j;
}

}  // namespace

CORNICE_CLONES
void encode_octahedral(NormalLanes& lanes, int bits) {
  const std::int32_t limit = octahedral_limit(bits);
  const auto scale = static_cast<float>(limit);
  const float step = 1.0f / scale;
  Floats x, y, z, ax, ay, az, au, av;
  std::memcpy(&x, &lanes.x, sizeof x), std::memcpy(&y, &lanes.y, sizeof y);
  std::memcpy(&z, &lanes.z, sizeof z);
  set_absolute(x, ax), set_absolute(y, ay), set_absolute(z, az);
  const Floats sum = ax + ay + az, one = Floats{} + 1.0f;
  const Floats part = 1.0f / (sum > 0 ? sum : one);
  const Floats u = x * part, v = y * part;
  set_absolute(u, au), set_absolute(v, av);
  const Floats low_u = (1.0f - av) * (u < 0 ? -one : one);
  const Floats low_v = (1.0f - au) * (v < 0 ? -one : one);
  Words left, low;
  set_floor(((z < 0 ? low_u : u) + 1.0f) * scale, scale, left);
  set_floor(((z < 0 ? low_v : v) + 1.0f) * scale, scale, low);
  const Words most = Words{} + limit;
  const Words right = left < most ? left + 1 : most, high = low < most ? low + 1 : most;
  Best best{Floats{} - std::numeric_limits<float>::infinity(), left, low};
  compare(x, y, z, step, left, low, best), compare(x, y, z, step, right, low, best);
  compare(x, y, z, step, left, high, best), compare(x, y, z, step, right, high, best);
  std::memcpy(&lanes.i, &best.i, sizeof best.i), std::memcpy(&lanes.j, &best.j, sizeof best.j);
}

}  // namespace cornice::hlod
