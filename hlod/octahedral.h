// SPDX-License-Identifier: GPL-3.0-or-later
// Unit vectors as two whole numbers: the octahedron |x| + |y| + |z| = 1, its lower half folded out.
// Meyer, Suessmuth, Sussner, Stamminger and Greiner 2010, "On Floating-Point Normal Vectors";
// rounding to the nearest of four as Cigolle, Donow, Evangelakos, Mara, McGuire and Meyer 2014,
// "A Survey of Efficient Representations for Independent Unit Vectors".
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/vec.h"

namespace cornice::hlod {

/// Components lie in [-limit, limit].
constexpr int octahedral_limit(int bits) { return (1 << (bits - 1)) - 1; }

/// The unit vector of two components of `bits` bits, 2..16. Defined for every pair of values.
inline Vec3f decode_octahedral(std::array<std::int16_t, 2> packed, int bits) {
  const float scale = 1.0f / static_cast<float>(octahedral_limit(bits));
  float x = static_cast<float>(packed[0]) * scale;
  float y = static_cast<float>(packed[1]) * scale;
  const float z = 1.0f - std::abs(x) - std::abs(y);
  // Below the equator each corner of the square is folded onto the octahedron's lower half.
  const float fold = z < 0.0f ? -z : 0.0f;
  x += x >= 0.0f ? -fold : fold;
  y += y >= 0.0f ? -fold : fold;
  return normalized(Vec3f{x, y, z});
}

/// The square's point of a direction, before rounding; (0, 0), that is up, for a zero vector.
inline std::array<double, 2> octahedral_point(Vec3d n) {
  const double sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
  if (!(sum > 0.0)) return {0.0, 0.0};
  const double scale = 1.0 / sum, x = n.x * scale, y = n.y * scale;
  if (n.z >= 0.0) return {x, y};
  return {std::copysign(1.0 - std::abs(y), x), std::copysign(1.0 - std::abs(x), y)};
}

/// Rounded to the nearest point of the square; up to twice as far off as encode_octahedral.
inline std::array<std::int16_t, 2> round_octahedral(Vec3d n, int bits) {
  const auto [x, y] = octahedral_point(n);
  const double limit = octahedral_limit(bits);
  // By way of a positive number: floor() is a call where it is not an instruction.
  const auto rounded = [](double value) {
    return static_cast<std::int16_t>(static_cast<std::int32_t>(value + 65536.5) - 65536);
  };
  return {rounded(x * limit), rounded(y * limit)};
}

/// The pair whose unit vector is nearest to n; n need not be of unit length, zero counts as up.
/// Off by at most 0.95 degrees with 8 bits, 0.24 degrees with 10 bits.
inline std::array<std::int16_t, 2> encode_octahedral(Vec3f n, int bits) {
  const auto [x, y] = octahedral_point(n.cast<double>());
  const int limit = octahedral_limit(bits);
  const int left = static_cast<int>(std::floor(x * limit));
  const int low = static_cast<int>(std::floor(y * limit));
  std::array<std::int16_t, 2> best{};
  float nearest = -std::numeric_limits<float>::infinity();
  for (int corner = 0; corner < 4; ++corner) {
    const int i = left + (corner & 1), j = low + (corner >> 1);
    if (i > limit || j > limit) continue;
    const std::array<std::int16_t, 2> packed{static_cast<std::int16_t>(i),
                                             static_cast<std::int16_t>(j)};
    const float cosine = dot(decode_octahedral(packed, bits), n);
    if (cosine > nearest) nearest = cosine, best = packed;
  }
  return best;
}

}  // namespace cornice::hlod
