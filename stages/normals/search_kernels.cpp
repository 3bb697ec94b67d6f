// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/search_kernels.h"

#include <cstring>

#include "core/base/clones.h"

namespace cornice::normals {
namespace {

/// Eight lanes: one AVX register, or two of SSE.
constexpr std::size_t kLanes = 8;
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
static_assert(kRungs == kLanes && kWordBits == 4 * kLanes);

template <class V, class T>
[[gnu::always_inline]] inline void load(V& lanes, const T* from) {
  std::memcpy(&lanes, from, sizeof(V));
}

/// What lane l of part q of a word marks: bit 8 q + l.
alignas(32) constexpr std::array<std::int32_t, kWordBits> kBits = [] {
  std::array<std::int32_t, kWordBits> bits{};
  for (std::size_t b = 0; b < bits.size(); ++b) bits[b] = static_cast<std::int32_t>(1u << b);
  return bits;
}();

[[gnu::always_inline]] inline std::uint32_t all_bits(const Ints& lanes) {
  std::array<std::uint64_t, 4> halves;
  std::memcpy(&halves, &lanes, sizeof lanes);
  const std::uint64_t word = (halves[0] | halves[1]) | (halves[2] | halves[3]);
  return static_cast<std::uint32_t>(word | word >> 32);
}

}  // namespace

CORNICE_CLONES
void measure(const float* x, const float* y, const float* z, std::size_t n, Vec3f p,
             std::int32_t* dist_sq) {
  const std::size_t padded = (n + kWordBits - 1) / kWordBits * kWordBits;
  for (std::size_t j = 0; j < padded; j += kLanes) {
    Floats dx, dy, dz;
    load(dx, x + j), load(dy, y + j), load(dz, z + j);
    dx -= p.x, dy -= p.y, dz -= p.z;
    const Floats sum = dx * dx + dy * dy + dz * dz;
    std::memcpy(dist_sq + j, &sum, sizeof sum);
  }
}

CORNICE_CLONES
Rungs count_within(const std::int32_t* values, std::size_t n, const Rungs& limits) {
  Ints limit, even{}, odd{};
  load(limit, limits.data());
  std::size_t j = 0;
  // A comparison gives -1 where it holds. "Greater" is the one that SSE and AVX have.
  for (; j + 2 <= n; j += 2) {
    even += values[j] > limit;
    odd += values[j + 1] > limit;
  }
  if (j < n) even += values[j] > limit;
  const Ints within = static_cast<std::int32_t>(n) + even + odd;
  Rungs result;
  std::memcpy(result.data(), &within, sizeof result);
  return result;
}

CORNICE_CLONES
void mark_within(const std::int32_t* values, std::size_t words_count, std::int32_t limit,
                 std::uint32_t* words) {
  for (std::size_t w = 0; w < words_count; ++w) {
    Ints marked{};
    for (std::size_t b = 0; b < kWordBits; b += kLanes) {
      Ints value, bits;
      load(value, values + w * kWordBits + b), load(bits, kBits.data() + b);
      marked |= (value > limit) & bits;
    }
    words[w] = ~all_bits(marked);
  }
}

CORNICE_CLONES
std::uint32_t mark_inside(const float* x, const float* y, const float* z, Vec3f low, Vec3f high) {
  Ints marked{};
  for (std::size_t b = 0; b < kWordBits; b += kLanes) {
    Floats px, py, pz;
    Ints bits;
    load(px, x + b), load(py, y + b), load(pz, z + b), load(bits, kBits.data() + b);
    marked |= (px >= low.x) & (px <= high.x) & (py >= low.y) & (py <= high.y) & (pz >= low.z) &
              (pz <= high.z) & bits;
  }
  return all_bits(marked);
}

}  // namespace cornice::normals
