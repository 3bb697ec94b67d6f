// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts the loop of one cell into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/vec.h"

namespace cornice {

/// A corner of a loop.
struct LoopCorner {
  std::uint32_t vertex = 0;
  std::uint8_t faces = 0;   ///< of the cell on which it lies, as bits
  Vec3<std::int32_t> at{};  ///< in any unit that is the same for all corners
};

inline constexpr std::size_t kMaxLoop = 12;
using LoopTriangles = std::array<std::array<std::uint8_t, 3>, kMaxLoop>;

/// Cuts a loop of 3 to 12 corners into loop.size() - 2 triangles, as indices of corners, with
/// diagonals whose squares add up to the least. No diagonal joins two corners on one face of the
/// cell: the cell beyond could have the same one, and four triangles would meet there. Returns how
/// many triangles there are; 0 where such diagonals leave no way.
std::size_t cut_loop(std::span<const LoopCorner> loop, LoopTriangles& triangles);

}  // namespace cornice
