// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of the square grids that benches make their ground of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice::bench {

/// Two a cell over side x side vertices, row by row from the south, columns from the west.
inline std::vector<Triangle> grid_triangles(std::size_t side) {
  std::vector<Triangle> triangles;
  triangles.reserve(2 * (side - 1) * (side - 1));
  const auto up = static_cast<std::uint32_t>(side);
  for (std::size_t row = 0; row + 1 < side; ++row) {
    for (std::size_t column = 0; column + 1 < side; ++column) {
      const auto a = static_cast<std::uint32_t>(row * side + column);
      triangles.push_back({a, a + 1, a + up + 1});
      triangles.push_back({a, a + up + 1, a + up});
    }
  }
  return triangles;
}

}  // namespace cornice::bench
