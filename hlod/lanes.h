// SPDX-License-Identifier: GPL-3.0-or-later
// Eight numbers at a time, on any machine: compilers make two or four instructions of one where
// registers are short. Each lane does the same arithmetic everywhere.
#pragma once

#include <cstdint>
#include <cstring>

namespace cornice::hlod {

// g++ aligns eight lanes to 16 bytes where AVX is off, but takes 32 for granted in a clone with
// AVX2 (core/base/clones.h): a struct that holds them says alignas(32).
using Float4 [[gnu::vector_size(16)]] = float;
using Float8 [[gnu::vector_size(32)]] = float;
using Int4 [[gnu::vector_size(16)]] = std::int32_t;
using Int8 [[gnu::vector_size(32)]] = std::int32_t;

// g++ 11 has the older of the two alone.
#if defined(__clang__) || __GNUC__ >= 12
#define CORNICE_SHUFFLE8(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#define CORNICE_SHUFFLE4(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define CORNICE_SHUFFLE8(a, b, ...) __builtin_shuffle(a, b, Int8{__VA_ARGS__})
#define CORNICE_SHUFFLE4(a, b, ...) __builtin_shuffle(a, b, Int4{__VA_ARGS__})
#endif
/// How vectors of eight are returned differs between instruction sets: they are written instead.
#define CORNICE_INLINE [[gnu::always_inline]] inline

inline constexpr Int8 kLaneNumbers{0, 1, 2, 3, 4, 5, 6, 7};

template <class T>
CORNICE_INLINE void load_lanes(const void* from, T& lanes) {
  std::memcpy(&lanes, from, sizeof lanes);
}
template <class T>
CORNICE_INLINE void store_lanes(void* to, const T& lanes) {
  std::memcpy(to, &lanes, sizeof lanes);
}

CORNICE_INLINE void join(const Float4& low, const Float4& high, Float8& both) {
#if defined(__clang__) || __GNUC__ >= 12
  both = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  both = Float8{low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]};
#endif
}
CORNICE_INLINE Int4 low_half(const Int8& a) { return Int4{a[0], a[1], a[2], a[3]}; }
CORNICE_INLINE Int4 high_half(const Int8& a) { return Int4{a[4], a[5], a[6], a[7]}; }

/// All lanes, combined by or.
CORNICE_INLINE std::int32_t or_of_lanes(const Int8& a) {
  Int4 half = low_half(a) | high_half(a);
  half |= CORNICE_SHUFFLE4(half, half, 2, 3, 0, 1);
  half |= CORNICE_SHUFFLE4(half, half, 1, 0, 3, 2);
  return half[0];
}
CORNICE_INLINE std::int32_t least_of_lanes(const Int8& a) {
  const Int4 low = low_half(a), high = high_half(a);
  Int4 half = low < high ? low : high;
  Int4 other = CORNICE_SHUFFLE4(half, half, 2, 3, 0, 1);
  half = half < other ? half : other;
  other = CORNICE_SHUFFLE4(half, half, 1, 0, 3, 2);
  half = half < other ? half : other;
  return half[0];
}
/// Lanes 1 to 7 of a, then lane 0 of b.
CORNICE_INLINE void one_on(const Float8& a, const Float8& b, Float8& lanes) {
  lanes = CORNICE_SHUFFLE8(a, b, 1, 2, 3, 4, 5, 6, 7, 8);
}

/// Coordinates of eight points.
CORNICE_INLINE void gather_points(const Float4* points, const std::uint32_t* names, Float8& x,
                                  Float8& y, Float8& z) {
  Float8 a, b, c, d;
  join(points[names[0]], points[names[4]], a);
  join(points[names[1]], points[names[5]], b);
  join(points[names[2]], points[names[6]], c);
  join(points[names[3]], points[names[7]], d);
  const Float8 ab = CORNICE_SHUFFLE8(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 cd = CORNICE_SHUFFLE8(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Float8 ab_z = CORNICE_SHUFFLE8(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Float8 cd_z = CORNICE_SHUFFLE8(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  x = CORNICE_SHUFFLE8(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13);
  y = CORNICE_SHUFFLE8(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15);
  z = CORNICE_SHUFFLE8(ab_z, cd_z, 0, 1, 8, 9, 4, 5, 12, 13);
}

}  // namespace cornice::hlod
