// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/closed_brick.h"

#include <algorithm>
#include <array>

namespace cornice {
namespace {

constexpr int kClosedSide = kBrickSide + 1;

constexpr int at9(int x, int y, int z) { return x + kClosedSide * (y + kClosedSide * z); }
constexpr int at8(int x, int y, int z) { return x + kBrickSide * (y + kBrickSide * z); }

/// Copies the nodes that brick + (dx, dy, dz) owns into the closed nodes of `brick`.
void copy_owned(const float* owner, int dx, int dy, int dz, float* closed) {
  const int nx = dx ? 1 : kBrickSide, ny = dy ? 1 : kBrickSide, nz = dz ? 1 : kBrickSide;
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      std::copy_n(owner + at8(0, y, z), nx,
                  closed + at9(kBrickSide * dx, y + kBrickSide * dy, z + kBrickSide * dz));
    }
  }
}

/// Mean of the two coarse nodes around fine node `c`, which may be one and the same. The order of
/// the additions depends on the parity of (x, y, z) only, so that a node has the same bits in every
/// brick it is read with.
float interpolate(const float* coarse, int x, int y, int z) {
  const int x0 = x >> 1, x1 = (x + 1) >> 1, y0 = y >> 1, y1 = (y + 1) >> 1;
  const auto along_x = [&](int j, int k) {
    return x0 == x1 ? coarse[at9(x0, j, k)]
                    : 0.5f * (coarse[at9(x0, j, k)] + coarse[at9(x1, j, k)]);
  };
  const auto along_y = [&](int k) {
    return y0 == y1 ? along_x(y0, k) : 0.5f * (along_x(y0, k) + along_x(y1, k));
  };
  const int z0 = z >> 1, z1 = (z + 1) >> 1;
  return z0 == z1 ? along_y(z0) : 0.5f * (along_y(z0) + along_y(z1));
}

/// Where `brick` starts within its parent, in nodes of the parent.
constexpr int half_of(std::int32_t b) { return (b & 1) * (kBrickSide / 2); }

}  // namespace

bool read_closed_brick(std::span<const LevelView> levels, BrickKey brick,
                       std::span<float, kClosedBrickNodes> values) {
  if (levels.empty()) return false;
  const LevelView& here = levels.front();
  std::array<std::uint32_t, 8> owners;
  bool all_stored = true;
  for (int o = 0; o < 8; ++o) {
    owners[o] = here.index->find(here.bricks, shifted(brick, o & 1, o >> 1 & 1, o >> 2));
    all_stored = all_stored && owners[o] != BrickIndex::kNone;
  }
  if (!all_stored) {
    std::array<float, kClosedBrickNodes> coarse;
    if (!read_closed_brick(levels.subspan(1), parent(brick), coarse)) return false;
    const float* from = coarse.data() + at9(half_of(brick.x), half_of(brick.y), half_of(brick.z));
    for (int z = 0; z < kClosedSide; ++z) {
      for (int y = 0; y < kClosedSide; ++y) {
        for (int x = 0; x < kClosedSide; ++x) values[at9(x, y, z)] = interpolate(from, x, y, z);
      }
    }
  }
  for (int o = 0; o < 8; ++o) {
    if (owners[o] == BrickIndex::kNone) continue;
    copy_owned(here.values.data() + std::size_t{owners[o]} * kBrickNodes, o & 1, o >> 1 & 1, o >> 2,
               values.data());
  }
  return true;
}

}  // namespace cornice
