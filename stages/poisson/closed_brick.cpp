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

constexpr int kHalfSide = kBrickSide / 2 + 1;

/// The means of `count` pairs.
void add_halves(const float* a, const float* b, int count, float* sum) {
  for (int i = 0; i < count; ++i) sum[i] = 0.5f * (a[i] + b[i]);
}

/// The closed nodes of a brick from the 5 x 5 x 5 of its parent that start at `coarse`: along x,
/// then y, then z, whole rows and planes at a time. The order of the additions depends on the
/// parity of a node alone, so that it has the same bits in every brick it is read with.
void interpolate(const float* coarse, float* fine) {
  constexpr int kPlane = kClosedSide * kClosedSide;
  std::array<float, kClosedSide * kHalfSide * kHalfSide> along_x;
  std::array<float, kPlane * kHalfSide> along_y;
  for (int k = 0; k < kHalfSide; ++k) {
    float* plane = along_y.data() + kPlane * k;
    for (int j = 0; j < kHalfSide; ++j) {
      const float* from = coarse + at9(0, j, k);
      float* row = along_x.data() + kClosedSide * (j + kHalfSide * k);
      for (int x = 0; x < kClosedSide; ++x) {
        row[x] = (x & 1) == 0 ? from[x / 2] : 0.5f * (from[x / 2] + from[x / 2 + 1]);
      }
      std::copy_n(row, kClosedSide, plane + kClosedSide * 2 * j);
      if (j > 0) add_halves(row - kClosedSide, row, kClosedSide, plane + kClosedSide * (2 * j - 1));
    }
    std::copy_n(plane, kPlane, fine + kPlane * 2 * k);
    if (k > 0) add_halves(plane - kPlane, plane, kPlane, fine + kPlane * (2 * k - 1));
  }
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
    interpolate(from, values.data());
  }
  for (int o = 0; o < 8; ++o) {
    if (owners[o] == BrickIndex::kNone) continue;
    copy_owned(here.values.data() + std::size_t{owners[o]} * kBrickNodes, o & 1, o >> 1 & 1, o >> 2,
               values.data());
  }
  return true;
}

}  // namespace cornice
