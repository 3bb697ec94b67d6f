// SPDX-License-Identifier: GPL-3.0-or-later
// How a surface passes through one cell of a grid, from the signs of its eight nodes.
//
//      6-------7          node  c = i + 2 j + 4 k
//     /|      /|          edges 0..3  along x: j + 2 k
//    4-------5 |                4..7  along y: i + 2 k
//    | 2-----|-3                8..11 along z: i + 2 j
//    |/      |/           faces 0 x=0, 1 x=1, 2 y=0, 3 y=1, 4 z=0, 5 z=1
//    0-------1
#pragma once

#include <array>
#include <cstdint>

namespace cornice {

/// Closed loops over the edges of a cell, the loops one after the other in `edges`. They run
/// counter-clockwise seen from the positive side. A crossed edge is in one loop, once.
struct CellLoops {
  std::uint8_t loops = 0;
  std::array<std::uint8_t, 4> length{};
  std::array<std::uint8_t, 12> edges{};
};

/// The four nodes of each face, counter-clockwise seen from outside.
inline constexpr std::array<std::array<std::uint8_t, 4>, 6> kFaceNodes{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

/// The faces (bits) on which an edge of a cell lies, by edge.
inline constexpr std::array<std::uint8_t, 12> kEdgeFaces = [] {
  std::array<std::uint8_t, 12> faces{};
  for (unsigned e = 0; e < 12; ++e) {
    const unsigned low = e & 1, high = e >> 1 & 1;
    // The two axes across the edge, the one that counts first in its number before the other.
    const unsigned first = e < 4 ? 1 : 0, second = e < 8 ? 2 : 1;
    faces[e] = static_cast<std::uint8_t>(1u << (2 * first + low) | 1u << (2 * second + high));
  }
  return faces;
}();

/// Faces (bits) whose signs alternate around them; `negative`: bit c is set where node c is < 0.
std::uint8_t ambiguous_faces(unsigned negative);

/// The loops of a cell. `joined`: faces (bits) whose two negative corners are connected across the
/// face where it is ambiguous; other bits do not matter. Lorensen & Cline, "Marching Cubes" (1987),
/// with each face decided by itself, so that both cells of a face agree whatever lies behind it.
const CellLoops& cell_loops(unsigned negative, unsigned joined);

}  // namespace cornice
