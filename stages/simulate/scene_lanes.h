// SPDX-License-Identifier: GPL-3.0-or-later
// Four numbers at once: what the fields of a scene are evaluated in. The attribute is understood by
// g++ and clang alike and needs no particular processor; every lane is rounded as a single number.
#pragma once

#include <cstdint>
#include <cstring>

namespace cornice::simulate {

typedef float Float4 __attribute__((vector_size(16)));
typedef std::int32_t Int4 __attribute__((vector_size(16)));
typedef double Double4 __attribute__((vector_size(32)));

inline Float4 load4(const float* from) {
  Float4 value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
inline Float4 spread(float value) { return Float4{value, value, value, value}; }
inline Double4 to_double(Float4 v) { return __builtin_convertvector(v, Double4); }
inline Float4 to_float(Double4 v) { return __builtin_convertvector(v, Float4); }
inline Double4 to_double(Int4 v) { return __builtin_convertvector(v, Double4); }

/// Largest integers not above v, or one more where v is less than 1e-9 below them; |v| < 1e6.
/// Without a comparison, which g++ takes apart into single numbers.
inline Int4 floor4(Double4 v) {
  constexpr std::int32_t kShift = 1 << 20;
  return __builtin_convertvector(v + kShift, Int4) - kShift;
}

#if defined(__clang__)
#define CORNICE_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define CORNICE_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, Int4{i, j, k, l})
#endif

/// Turns four rows into four columns, in place.
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
  const Float4 ac_low = CORNICE_SHUFFLE(a, c, 0, 4, 1, 5);
  const Float4 ac_high = CORNICE_SHUFFLE(a, c, 2, 6, 3, 7);
  const Float4 bd_low = CORNICE_SHUFFLE(b, d, 0, 4, 1, 5);
  const Float4 bd_high = CORNICE_SHUFFLE(b, d, 2, 6, 3, 7);
  a = CORNICE_SHUFFLE(ac_low, bd_low, 0, 4, 1, 5);
  b = CORNICE_SHUFFLE(ac_low, bd_low, 2, 6, 3, 7);
  c = CORNICE_SHUFFLE(ac_high, bd_high, 0, 4, 1, 5);
  d = CORNICE_SHUFFLE(ac_high, bd_high, 2, 6, 3, 7);
}
#undef CORNICE_SHUFFLE

/// Four places in memory and what stands `offset` after each, column by column.
struct Lanes {
  const float* from[4];

  void load(std::size_t offset, Float4 (&columns)[4]) const {
    for (int lane = 0; lane < 4; ++lane) columns[lane] = load4(from[lane] + offset);
    transpose(columns[0], columns[1], columns[2], columns[3]);
  }
};

}  // namespace cornice::simulate
