// SPDX-License-Identifier: GPL-3.0-or-later
// Many unit vectors as two whole numbers each; see octahedral.h.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/vec.h"

namespace cornice::hlod {

struct alignas(32) NormalLanes {
  static constexpr std::size_t kCount = 8;
  std::array<float, kCount> x{}, y{}, z{};
  std::array<std::int32_t, kCount> i{}, j{};
};

/// As decode_octahedral for each lane, the same numbers: x, y and z from i and j.
void decode_octahedral(NormalLanes& lanes, int bits);
/// As encode_octahedral for each lane, the same numbers.
void encode_octahedral(NormalLanes& lanes, int bits);

/// Calls put(v, packed) for v in [begin, end) with the encoding of normal_of(v).
template <class NormalOf, class Put>
void encode_octahedral(std::size_t begin, std::size_t end, int bits, const NormalOf& normal_of,
                       const Put& put) {
  NormalLanes lanes;
  for (std::size_t first = begin; first < end; first += NormalLanes::kCount) {
    const std::size_t count = std::min(end - first, NormalLanes::kCount);
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3f n = normal_of(first + k);
      lanes.x[k] = n.x, lanes.y[k] = n.y, lanes.z[k] = n.z;
    }
    encode_octahedral(lanes, bits);
    for (std::size_t k = 0; k < count; ++k) {
      put(first + k,
          std::array{static_cast<std::int16_t>(lanes.i[k]), static_cast<std::int16_t>(lanes.j[k])});
    }
  }
}

}  // namespace cornice::hlod
