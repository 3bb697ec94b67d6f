// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/equations.h"

#include <cstring>

namespace cornice::poisson {
namespace {

/// Copies the planes [low, high] of the brick (bx, by, bz) away that a halo has room for.
void load_from(const float* owner, int bx, int by, int bz, int low, int high, Halo& halo) {
  const auto begin = [](int b) { return b < 0 ? 7 : 0; };
  const auto end = [](int b) { return b > 0 ? 1 : 8; };
  for (int z = std::max(begin(bz), low - 8 * bz); z < std::min(end(bz), high + 1 - 8 * bz); ++z) {
    for (int y = begin(by); y < end(by); ++y) {
      const float* from = owner + kBrickSide * (y + kBrickSide * z);
      float* to = halo.row(8 * by + y, 8 * bz + z);
      if (bx == 0) {
        std::memcpy(to, from, kBrickSide * sizeof(float));
      } else if (bx < 0) {
        to[-1] = from[7];
      } else {
        to[8] = from[0];
      }
    }
  }
}

/// Mirrors the nodes next to a border of the domain: no flow across it (Neumann). `missing` tells
/// for the low and high side of each axis.
void reflect(const std::array<std::array<bool, 2>, 3>& missing, Halo& halo) {
  for (int side = 0; side < 2; ++side) {
    const int to = side == 0 ? -1 : kBrickSide, from = side == 0 ? 1 : kBrickSide - 2;
    for (int z = -1; z <= kBrickSide && missing[0][side]; ++z) {
      for (int y = -1; y <= kBrickSide; ++y) halo.row(y, z)[to] = halo.row(y, z)[from];
    }
  }
  for (int side = 0; side < 2; ++side) {
    const int to = side == 0 ? -1 : kBrickSide, from = side == 0 ? 1 : kBrickSide - 2;
    for (int z = -1; z <= kBrickSide && missing[1][side]; ++z)
      std::copy_n(halo.row(from, z) - 1, kHaloSide, halo.row(to, z) - 1);
  }
  for (int side = 0; side < 2; ++side) {
    const int to = side == 0 ? -1 : kBrickSide, from = side == 0 ? 1 : kBrickSide - 2;
    for (int y = -1; y <= kBrickSide && missing[2][side]; ++y)
      std::copy_n(halo.row(y, from) - 1, kHaloSide, halo.row(y, to) - 1);
  }
}

}  // namespace

void load_stored(const Grid& grid, std::size_t brick, int low, int high, Halo& halo) {
  const Neighbours& around = grid.neighbours[brick];
  for (int n = 0; n < 27; ++n) {
    if (around[n] == BrickIndex::kNone) continue;
    load_from(grid.values.data() + std::size_t{around[n]} * kBrickNodes, n % 3 - 1, n / 3 % 3 - 1,
              n / 9 - 1, low, high, halo);
  }
}

void load(const Grid& grid, std::size_t brick, const Equations& equations, Halo& halo) {
  load_stored(grid, brick, equations.low - 1, equations.high + 1, halo);
  if (!grid.whole) return;
  const auto none = [&](int n) { return grid.neighbours[brick][n] == BrickIndex::kNone; };
  reflect({{{none(12), none(14)}, {none(10), none(16)}, {none(4), none(22)}}}, halo);
}

}  // namespace cornice::poisson
