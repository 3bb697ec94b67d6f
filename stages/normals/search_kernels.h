// SPDX-License-Identifier: GPL-3.0-or-later
// The inner loops of the neighbour search: straight, without branches, over many candidates.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/base/vec.h"

namespace cornice::normals {

/// Candidates that share one word of marks. Arrays of candidates must be readable, though not
/// filled, to a whole number of these.
constexpr std::size_t kWordBits = 32;

/// Limits that are counted side by side, in ascending order.
constexpr std::size_t kRungs = 8;
using Rungs = std::array<std::int32_t, kRungs>;

/// Bits of a float >= 0; they are in the order of the floats.
inline std::int32_t bits_of(float value) { return std::bit_cast<std::int32_t>(value); }

/// dist_sq[j] = bits of the squared distance from p to candidate j, j < n rounded up to whole
/// words.
void measure(const float* x, const float* y, const float* z, std::size_t n, Vec3f p,
             std::int32_t* dist_sq);

/// How many of `values` do not exceed each limit.
Rungs count_within(const std::int32_t* values, std::size_t n, const Rungs& limits);

/// Bit b of words[w]: values[kWordBits * w + b] <= limit, for w < words_count.
void mark_within(const std::int32_t* values, std::size_t words_count, std::int32_t limit,
                 std::uint32_t* words);

/// Bit b: candidate b of kWordBits lies in the closed box.
std::uint32_t mark_inside(const float* x, const float* y, const float* z, Vec3f low, Vec3f high);

}  // namespace cornice::normals
