// SPDX-License-Identifier: GPL-3.0-or-later
// Gauss-Seidel over bricks in eight colours: bricks of one colour do not touch, so they can be
// worked on at the same time, and what each reads does not depend on which thread comes first.
// Within a brick, rows of eight nodes are solved one after the other, forwards and backwards.
#include "stages/poisson/relax.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "stages/poisson/vector_clones.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 32;
constexpr int kSide = kBrickSide + 2;
constexpr int kStride = 16;
constexpr int kFirst = 4;  ///< where node 0 of a row is: aligned, with room for node -1
/// Trilinear stiffness over the spacing: the node itself, neighbours across an edge of a cell's
/// face, neighbours across a cell; those along an axis take no part.
constexpr float kCentre = 8.0f / 3.0f, kEdge = 1.0f / 6.0f, kCorner = 1.0f / 12.0f;

/// Values of a brick's nodes and one around: [z + 1][y + 1][x + kFirst].
struct alignas(64) Halo {
  std::array<std::array<std::array<float, kStride>, kSide>, kSide> at{};
};

/// Masks of eight lanes for every byte.
struct LaneMasks {
  alignas(64) std::array<std::array<float, kBrickSide>, 256> of;
  constexpr LaneMasks() : of() {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      for (std::size_t i = 0; i < kBrickSide; ++i) of[byte][i] = byte >> i & 1 ? 1.0f : 0.0f;
    }
  }
};
constexpr LaneMasks kLaneMasks;

void load_from(const float* owner, int bx, int by, int bz, Halo& halo) {
  const auto begin = [](int b) { return b < 0 ? 7 : 0; };
  const auto end = [](int b) { return b > 0 ? 1 : 8; };
  for (int z = begin(bz); z < end(bz); ++z) {
    for (int y = begin(by); y < end(by); ++y) {
      const float* from = owner + kBrickSide * (y + kBrickSide * z);
      float* to = halo.at[8 * bz + z + 1][8 * by + y + 1].data() + kFirst;
      if (bx == 0) {
        std::copy_n(from, kBrickSide, to);
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
    const int to = side == 0 ? 0 : kSide - 1, from = side == 0 ? 2 : kSide - 3;
    if (missing[0][side]) {
      for (auto& plane : halo.at) {
        for (auto& row : plane) row[kFirst - 1 + to] = row[kFirst - 1 + from];
      }
    }
  }
  for (int side = 0; side < 2; ++side) {
    const int to = side == 0 ? 0 : kSide - 1, from = side == 0 ? 2 : kSide - 3;
    if (missing[1][side]) {
      for (auto& plane : halo.at) plane[to] = plane[from];
    }
  }
  for (int side = 0; side < 2; ++side) {
    const int to = side == 0 ? 0 : kSide - 1, from = side == 0 ? 2 : kSide - 3;
    if (missing[2][side]) halo.at[to] = halo.at[from];
  }
}

void load(const Grid& grid, std::size_t brick, Halo& halo) {
  const Neighbours& around = grid.neighbours[brick];
  for (int n = 0; n < 27; ++n) {
    if (around[n] == BrickIndex::kNone) continue;
    load_from(grid.values.data() + std::size_t{around[n]} * kBrickNodes, n % 3 - 1, n / 3 % 3 - 1,
              n / 9 - 1, halo);
  }
  if (grid.whole) {
    const auto none = [&](int n) { return around[n] == BrickIndex::kNone; };
    reflect({{{none(12), none(14)}, {none(10), none(16)}, {none(4), none(22)}}}, halo);
  }
}

void store(const Halo& halo, float* values) {
  for (int r = 0; r < kBrickRows; ++r)
    std::copy_n(halo.at[(r >> 3) + 1][(r & 7) + 1].data() + kFirst, kBrickSide,
                values + kBrickSide * r);
}

/// What the equations of one row's nodes lack: constraint less stiffness and screening applied to
/// the values. `taps` is null where there is no screening.
inline void row_residual(const Halo& halo, int y, int z, const float* constraint, const float* taps,
                         float* lacking) {
  const auto row = [&](int j, int k) { return halo.at[z + 1 + k][y + 1 + j].data() + kFirst - 1; };
  const float *a = row(-1, 0), *b = row(1, 0), *c = row(0, -1), *d = row(0, 1);
  const float *e = row(-1, -1), *f = row(1, -1), *g = row(-1, 1), *h = row(1, 1);
  const float* own = row(0, 0);
  float face[kStride], diagonal[kStride];
  for (int i = 0; i < kSide; ++i) face[i] = (a[i] + b[i]) + (c[i] + d[i]);
  for (int i = 0; i < kSide; ++i) diagonal[i] = (e[i] + f[i]) + (g[i] + h[i]);
  for (int i = 0; i < kBrickSide; ++i) {
    lacking[i] = constraint[i] - kCentre * own[i + 1] +
                 kEdge * ((face[i] + face[i + 2]) + diagonal[i + 1]) +
                 kCorner * (diagonal[i] + diagonal[i + 2]);
  }
  if (taps == nullptr) return;
  for (int t = 0; t < Screening::kTaps; ++t) {
    const float* values = row(t / 3 % 3 - 1, t / 9 - 1) + t % 3;
    for (int i = 0; i < kBrickSide; ++i) lacking[i] -= taps[kBrickSide * t + i] * values[i];
  }
}

/// Moves one row's nodes to where their equations hold. Neighbours along the row move at the same
/// time; only screening ties them together, and adding its ties to the diagonal keeps that stable.
inline void relax_row(Halo& halo, int y, int z, const float* constraint, const float* taps,
                      std::uint8_t active) {
  float lacking[kBrickSide];
  row_residual(halo, y, z, constraint, taps, lacking);
  float* own = halo.at[z + 1][y + 1].data() + kFirst;
  const float* mask = kLaneMasks.of[active].data();
  if (taps == nullptr) {
    for (int i = 0; i < kBrickSide; ++i) own[i] += mask[i] * (lacking[i] * (1.0f / kCentre));
    return;
  }
  const float *before = taps + 12 * kBrickSide, *centre = taps + 13 * kBrickSide,
              *after = taps + 14 * kBrickSide;
  for (int i = 0; i < kBrickSide; ++i)
    own[i] += mask[i] * (lacking[i] / (kCentre + centre[i] + before[i] + after[i]));
}

using RowTaps = std::array<const float*, kBrickRows>;

CORNICE_VECTOR_CLONES
void relax_brick(Halo& halo, const float* constraints, const RowTaps& taps,
                 const RowMasks& active) {
  for (int r = 0; r < kBrickRows; ++r) {
    if (active[r]) relax_row(halo, r & 7, r >> 3, constraints + kBrickSide * r, taps[r], active[r]);
  }
  for (int r = kBrickRows - 1; r >= 0; --r) {
    if (active[r]) relax_row(halo, r & 7, r >> 3, constraints + kBrickSide * r, taps[r], active[r]);
  }
}

CORNICE_VECTOR_CLONES
void brick_residual(const Halo& halo, const float* constraints, const RowTaps& taps,
                    const RowMasks& active, double& left, double& zero) {
  for (int r = 0; r < kBrickRows; ++r) {
    float lacking[kBrickSide];
    row_residual(halo, r & 7, r >> 3, constraints + kBrickSide * r, taps[r], lacking);
    for (int i = 0; i < kBrickSide; ++i) {
      if (!(active[r] >> i & 1)) continue;
      left += static_cast<double>(lacking[i]) * static_cast<double>(lacking[i]);
      const auto b = static_cast<double>(constraints[kBrickSide * r + i]);
      zero += b * b;
    }
  }
}

RowTaps row_taps(const Screening& screening, std::size_t brick) {
  RowTaps taps{};
  for (int r = 0; r < kBrickRows; ++r) {
    if (screening.has_row(brick, r)) taps[r] = screening.row(brick, r);
  }
  return taps;
}

std::array<std::vector<std::uint32_t>, 8> colours(const Grid& grid) {
  std::array<std::vector<std::uint32_t>, 8> colour;
  for (std::uint32_t b = 0; b < grid.bricks.size(); ++b) {
    const BrickKey key = grid.bricks[b];
    const bool idle = std::all_of(grid.active[b].begin(), grid.active[b].end(),
                                  [](std::uint8_t row) { return row == 0; });
    if (!idle) colour[(key.x & 1) | (key.y & 1) << 1 | (key.z & 1) << 2].push_back(b);
  }
  return colour;
}

}  // namespace

void relax(Grid& grid, const Screening& screening, int passes, int threads) {
  const auto colour = colours(grid);
  for (int pass = 0; pass < passes; ++pass) {
    for (int c = 0; c < 8; ++c) {
      // To and fro, so that no colour always comes last.
      const std::vector<std::uint32_t>& bricks = colour[pass % 2 == 0 ? c : 7 - c];
      parallel_for(bricks.size(), kBricksAtATime, threads, [&](std::size_t begin, std::size_t end) {
        Halo halo;
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t b = bricks[i];
          load(grid, b, halo);
          relax_brick(halo, grid.constraints.data() + b * kBrickNodes, row_taps(screening, b),
                      grid.active[b]);
          store(halo, grid.values.data() + b * kBrickNodes);
        }
      });
    }
  }
}

Residual residual(const Grid& grid, const Screening& screening, int threads) {
  struct Sums {
    double left = 0.0, zero = 0.0;
  };
  const Sums sums = parallel_reduce(
      grid.bricks.size(), kBricksAtATime, threads, Sums{},
      [&](std::size_t begin, std::size_t end) {
        Sums part;
        Halo halo;
        for (std::size_t b = begin; b < end; ++b) {
          load(grid, b, halo);
          brick_residual(halo, grid.constraints.data() + b * kBrickNodes, row_taps(screening, b),
                         grid.active[b], part.left, part.zero);
        }
        return part;
      },
      [](Sums& sum, const Sums& part) { sum.left += part.left, sum.zero += part.zero; });
  const double count = std::max<double>(1.0, static_cast<double>(count_active(grid)));
  return {std::sqrt(sums.left / count), std::sqrt(sums.zero / count)};
}

}  // namespace cornice::poisson
