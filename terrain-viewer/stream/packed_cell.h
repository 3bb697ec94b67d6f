// SPDX-License-Identifier: GPL-3.0-or-later
// A cell as the vertex shader pulls it: words of 32 bits, nothing left to decode on the CPU.
#pragma once

#include <cstdint>
#include <vector>

#include "hlod/cell.h"

namespace cornice::viewer {

/// Words of a packed vertex (shaders/cell.glsl reads the same):
///   0, 1  position - lowest of the node, 21 bits each for x, y, z from the low end; of a parent in
///         steps of the level above, from the lowest of the node halved downwards
///   2     octahedral normal, two signed 16-bit halves
///   3     low half: index of the parent among the parents; high half: support, 1 cm
///   4     red, green, blue, source, a byte each from the low end
///   5     texture coordinates, two 16-bit halves
inline constexpr std::size_t kWordsPerVertex = 6;

struct PackedCell {
  std::uint32_t node = 0;            ///< row of the node table
  std::vector<std::uint32_t> words;  ///< the vertices, then the parents
  std::uint32_t vertex_count = 0;    ///< without the parents
  std::vector<std::uint16_t> indices;

  std::size_t bytes() const { return words.size() * 4 + indices.size() * 2; }
};

/// What parents' positions are counted from: the node's lowest corner in steps of the level above.
constexpr hlod::LatticePoint parent_origin(hlod::LatticePoint lowest) {
  return {lowest.x >> 1, lowest.y >> 1, lowest.z >> 1};
}

/// A vertex of the root level is its own parent. Throws InputError where a position does not fit
/// 21 bits, which no valid file has.
PackedCell pack_cell(const hlod::CellMesh& mesh, const hlod::Node& node, std::uint32_t row);

}  // namespace cornice::viewer
