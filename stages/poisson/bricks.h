// SPDX-License-Identifier: GPL-3.0-or-later
// Keys of the 8 x 8 x 8 bricks that a sparse grid is held in, and how to find one.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/random.h"

namespace cornice {

inline constexpr int kBrickSide = 8;                 ///< cells per axis
inline constexpr int kBrickNodes = 8 * 8 * 8;        ///< nodes that a brick owns
inline constexpr int kClosedBrickNodes = 9 * 9 * 9;  ///< with those of its far faces

/// Brick b of level l owns the nodes 8b .. 8b+7 (per axis) of that level.
struct BrickKey {
  std::int32_t x = 0, y = 0, z = 0;

  friend auto operator<=>(const BrickKey&, const BrickKey&) = default;
};

/// The brick of the next coarser level that covers `brick`.
constexpr BrickKey parent(BrickKey brick) { return {brick.x >> 1, brick.y >> 1, brick.z >> 1}; }

constexpr BrickKey shifted(BrickKey brick, int dx, int dy, int dz) {
  return {brick.x + dx, brick.y + dy, brick.z + dz};
}

/// Positions of N < 2^31 distinct keys in their array: a table with open addressing, half empty.
class BrickIndex {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  BrickIndex() = default;
  explicit BrickIndex(std::span<const BrickKey> bricks);

  /// Position of `brick` in the array that the index was made of, which is passed again; kNone
  /// where it is not there.
  std::uint32_t find(std::span<const BrickKey> bricks, BrickKey brick) const {
    if (slots_.empty()) return kNone;
    for (std::size_t slot = hash(brick) & mask_;; slot = (slot + 1) & mask_) {
      const std::uint32_t at = slots_[slot];
      if (at == kNone || bricks[at] == brick) return at;
    }
  }

 private:
  static std::size_t hash(BrickKey brick) {
    const auto bits = [](std::int32_t c) { return std::uint64_t{static_cast<std::uint32_t>(c)}; };
    return mix64(mix64(bits(brick.x) | bits(brick.y) << 32) + bits(brick.z));
  }

  std::vector<std::uint32_t> slots_;
  std::size_t mask_ = 0;
};

}  // namespace cornice
