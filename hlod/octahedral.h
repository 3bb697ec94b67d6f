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

struct OctahedralPair {
  std::int32_t i, j;
};

/// As encode_octahedral. Each line has its like in octahedral.cpp, for eight at a time.
inline OctahedralPair nearest_octahedral(float x, float y, float z, std::int32_t limit) {
  const auto scale = static_cast<float>(limit), step = 1.0f / scale;
  const float sum = std::abs(x) + std::abs(y) + std::abs(z);
  const float part = 1.0f / (sum > 0.0f ? sum : 1.0f);
  const float u = x * part, v = y * part;
  const float low_u = (1.0f - std::abs(v)) * (u < 0.0f ? -1.0f : 1.0f);
  const float low_v = (1.0f - std::abs(u)) * (v < 0.0f ? -1.0f : 1.0f);
  // By way of positive numbers: floor() is a call where it is not an instruction.
  const auto floor_of = [&](float upper, float lower) {
    const float moved = ((z < 0.0f ? lower : upper) + 1.0f) * scale;
    const float kept = moved > 0.0f ? moved : 0.0f;
    return static_cast<std::int32_t>(kept < 2 * scale ? kept : 2 * scale) - limit;
  };
  const std::int32_t left = floor_of(u, low_u), low = floor_of(v, low_v);
  const std::int32_t right = left < limit ? left + 1 : limit, high = low < limit ? low + 1 : limit;
  OctahedralPair best{left, low};
  float nearest = -std::numeric_limits<float>::infinity();
  const auto compare = [&](std::int32_t i, std::int32_t j) {
    const float across_x = static_cast<float>(i) * step, across_y = static_cast<float>(j) * step;
    const float pz = 1.0f - std::abs(across_x) - std::abs(across_y);
    const float fold = pz < 0.0f ? -pz : 0.0f;
    const float px = across_x + (across_x >= 0.0f ? -fold : fold);
    const float py = across_y + (across_y >= 0.0f ? -fold : fold);
    // The square of the cosine, with its sign, but for the length of (x, y, z): no root is taken.
    const float along = px * x + py * y + pz * z;
    const float cosine = along * std::abs(along) / (px * px + py * py + pz * pz);
    const bool is_nearer = cosine > nearest;
    nearest = is_nearer ? cosine : nearest;
    best.i = is_nearer ? i : best.i;
    best.j = is_nearer ? j : best.j;
  };
  compare(left, low), compare(right, low), compare(left, high), compare(right, high);
  return best;
}

/// The pair whose unit vector is nearest to n; n need not be of unit length, zero counts as up.
/// Off by at most 0.95 degrees with 8 bits, 0.24 degrees with 10 bits.
inline std::array<std::int16_t, 2> encode_octahedral(Vec3f n, int bits) {
  const OctahedralPair pair = nearest_octahedral(n.x, n.y, n.z, octahedral_limit(bits));
  return {static_cast<std::int16_t>(pair.i), static_cast<std::int16_t>(pair.j)};
}

}  // namespace cornice::hlod
