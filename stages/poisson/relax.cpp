// SPDX-License-Identifier: GPL-3.0-or-later
// Gauss-Seidel over bricks in eight colours: bricks of one colour do not touch, so they can be
// worked on at the same time, and what each reads does not depend on which thread comes first.
// Within a brick, rows of eight nodes are solved one after the other, forwards and backwards.
#include "stages/poisson/relax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/base/parallel.h"
#include "stages/poisson/vector_clones.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 32;
constexpr int kSide = kBrickSide + 2;
constexpr int kRow = 16;              ///< floats from row to row of a halo
constexpr int kPlane = kSide * kRow;  ///< from plane to plane
constexpr int kFirst = 4;             ///< where node 0 of a row is, with room for node -1
/// Trilinear stiffness over the spacing: the node itself, neighbours across an edge of a cell's
/// face, neighbours across a cell; those along an axis take no part.
constexpr float kCentre = 8.0f / 3.0f, kEdge = 1.0f / 6.0f, kCorner = 1.0f / 12.0f;

/// Values of a brick's nodes and one around. Zeros at first, so that what is never loaded is a
/// number.
struct alignas(64) Halo {
  std::array<float, kSide * kPlane> values{};
  float* row(int y, int z) { return values.data() + kPlane * (z + 1) + kRow * (y + 1) + kFirst; }
  const float* row(int y, int z) const { return const_cast<Halo*>(this)->row(y, z); }
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

/// What one brick's equations are made of.
struct Equations {
  const float* constraints;
  const RowMasks* active;
  std::array<const float*, kBrickRows> taps{};  ///< null where there is no screening
  int low = kBrickSide, high = -1;              ///< planes with active nodes

  Equations(const Grid& grid, const Screening& screening, std::size_t brick)
      : constraints(grid.constraints.data() + brick * kBrickNodes), active(&grid.active[brick]) {
    for (int r = 0; r < kBrickRows; ++r) {
      if ((*active)[r] == 0) continue;
      low = std::min(low, r >> 3);
      high = r >> 3;
      if (screening.has_row(brick, r)) taps[r] = screening.row(brick, r);
    }
  }
};

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
      std::copy_n(halo.row(from, z) - 1, kSide, halo.row(to, z) - 1);
  }
  for (int side = 0; side < 2; ++side) {
    const int to = side == 0 ? -1 : kBrickSide, from = side == 0 ? 1 : kBrickSide - 2;
    for (int y = -1; y <= kBrickSide && missing[2][side]; ++y)
      std::copy_n(halo.row(y, from) - 1, kSide, halo.row(y, to) - 1);
  }
}

void load(const Grid& grid, std::size_t brick, const Equations& equations, Halo& halo) {
  const Neighbours& around = grid.neighbours[brick];
  for (int n = 0; n < 27; ++n) {
    if (around[n] == BrickIndex::kNone) continue;
    load_from(grid.values.data() + std::size_t{around[n]} * kBrickNodes, n % 3 - 1, n / 3 % 3 - 1,
              n / 9 - 1, equations.low - 1, equations.high + 1, halo);
  }
  if (grid.whole) {
    const auto none = [&](int n) { return around[n] == BrickIndex::kNone; };
    reflect({{{none(12), none(14)}, {none(10), none(16)}, {none(4), none(22)}}}, halo);
  }
}

void store(const Halo& halo, const Equations& equations, float* values) {
  for (int z = equations.low; z <= equations.high; ++z) {
    for (int y = 0; y < kBrickSide; ++y)
      std::memcpy(values + kBrickSide * (y + kBrickSide * z), halo.row(y, z),
                  kBrickSide * sizeof(float));
  }
}

using Row = std::array<float, kBrickSide>;

/// Nine taps of one plane, applied to the values around `own`.
inline void apply_plane(const float* taps, const float* own, Row& sum) {
  const float *a = own - kRow, *b = own, *c = own + kRow;
  for (int i = 0; i < kBrickSide; ++i) {
    const float* t = taps + i;
    sum[i] = (t[0] * a[i - 1] + t[8] * a[i] + t[16] * a[i + 1]) +
             (t[24] * b[i - 1] + t[32] * b[i] + t[40] * b[i + 1]) +
             (t[48] * c[i - 1] + t[56] * c[i] + t[64] * c[i + 1]);
  }
}

/// What the equations of one row's nodes lack: constraint less stiffness and screening applied to
/// the values. `taps` is null where there is no screening.
inline void row_residual(const float* own, const float* constraint, const float* taps,
                         Row& lacking) {
  const float *a = own - kRow, *b = own + kRow, *c = own - kPlane, *d = own + kPlane;
  const float *e = c - kRow, *f = c + kRow, *g = d - kRow, *h = d + kRow;
  for (int i = 0; i < kBrickSide; ++i) {
    const float edges = ((a[i - 1] + a[i + 1]) + (b[i - 1] + b[i + 1])) +
                        ((c[i - 1] + c[i + 1]) + (d[i - 1] + d[i + 1])) +
                        ((e[i] + f[i]) + (g[i] + h[i]));
    const float corners = ((e[i - 1] + e[i + 1]) + (f[i - 1] + f[i + 1])) +
                          ((g[i - 1] + g[i + 1]) + (h[i - 1] + h[i + 1]));
    lacking[i] = (constraint[i] - kCentre * own[i]) + (kEdge * edges + kCorner * corners);
  }
  if (taps == nullptr) return;
  Row below, here, above;
  apply_plane(taps, own - kPlane, below);
  apply_plane(taps + 9 * kBrickSide, own, here);
  apply_plane(taps + 18 * kBrickSide, own + kPlane, above);
  for (int i = 0; i < kBrickSide; ++i) lacking[i] -= (below[i] + above[i]) + here[i];
}

/// Moves one row's nodes to where their equations hold. Neighbours along the row move at the same
/// time; only screening ties them together, and adding its ties to the diagonal keeps that stable.
inline void relax_row(float* own, const float* constraint, const float* taps, std::uint8_t active) {
  Row lacking;
  row_residual(own, constraint, taps, lacking);
  Row mask = kLaneMasks.of[active], moved;
  if (taps == nullptr) {
    for (int i = 0; i < kBrickSide; ++i)
      moved[i] = own[i] + mask[i] * (lacking[i] * (1.0f / kCentre));
  } else {
    const float *before = taps + 12 * kBrickSide, *centre = taps + 13 * kBrickSide,
                *after = taps + 14 * kBrickSide;
    for (int i = 0; i < kBrickSide; ++i) {
      const float diagonal = (kCentre + centre[i]) + (before[i] + after[i]);
      moved[i] = own[i] + mask[i] * (lacking[i] / diagonal);
    }
  }
  std::memcpy(own, moved.data(), sizeof(moved));
}

/// Rows in four colours by the parities of y and z, to and fro. Rows of one colour do not see each
/// other, so the processor need not wait for one before it starts the next.
CORNICE_VECTOR_CLONES
void relax_brick(Halo& halo, const Equations& equations) {
  constexpr std::array<int, 7> order{0, 1, 2, 3, 2, 1, 0};
  for (const int colour : order) {
    for (int z = colour >> 1; z < kBrickSide; z += 2) {
      for (int y = colour & 1; y < kBrickSide; y += 2) {
        const int r = y + kBrickSide * z;
        const std::uint8_t active = (*equations.active)[r];
        if (active)
          relax_row(halo.row(y, z), equations.constraints + kBrickSide * r, equations.taps[r],
                    active);
      }
    }
  }
}

CORNICE_VECTOR_CLONES
void brick_residual(const Halo& halo, const Equations& equations, double& left, double& zero) {
  for (int r = 0; r < kBrickRows; ++r) {
    const std::uint8_t active = (*equations.active)[r];
    if (active == 0) continue;
    const float* constraint = equations.constraints + kBrickSide * r;
    Row lacking;
    row_residual(halo.row(r & 7, r >> 3), constraint, equations.taps[r], lacking);
    const float* mask = kLaneMasks.of[active].data();
    float l = 0.0f, z = 0.0f;
    for (int i = 0; i < kBrickSide; ++i) {
      l += mask[i] * (lacking[i] * lacking[i]);
      z += mask[i] * (constraint[i] * constraint[i]);
    }
    left += static_cast<double>(l);
    zero += static_cast<double>(z);
  }
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
          const Equations equations(grid, screening, b);
          load(grid, b, equations, halo);
          relax_brick(halo, equations);
          store(halo, equations, grid.values.data() + b * kBrickNodes);
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
          const Equations equations(grid, screening, b);
          load(grid, b, equations, halo);
          brick_residual(halo, equations, part.left, part.zero);
        }
        return part;
      },
      [](Sums& sum, const Sums& part) { sum.left += part.left, sum.zero += part.zero; });
  const double count = std::max<double>(1.0, static_cast<double>(count_active(grid)));
  return {std::sqrt(sums.left / count), std::sqrt(sums.zero / count)};
}

}  // namespace cornice::poisson
