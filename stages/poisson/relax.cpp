// SPDX-License-Identifier: GPL-3.0-or-later
// Gauss-Seidel over bricks in eight colours: bricks of one colour do not touch, so they can be
// worked on at the same time, and what each reads does not depend on which thread comes first.
// Within a brick, rows of eight nodes are solved one after the other, forwards and backwards.
#include "stages/poisson/relax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

#include "core/base/clones.h"
#include "core/base/parallel.h"
#include "stages/poisson/equations.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 32;
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

void store(const Halo& halo, const Equations& equations, float* values) {
  for (int z = equations.low; z <= equations.high; ++z) {
    for (int y = 0; y < kBrickSide; ++y)
      std::memcpy(values + kBrickSide * (y + kBrickSide * z), halo.row(y, z),
                  kBrickSide * sizeof(float));
  }
}

/// Moves one row's nodes to where their equations hold.
inline void relax_row(float* own, const float* constraint, int y, int z, std::uint8_t active,
                      Pull& pull) {
  WideRow lacking, stiffness, moved;
  row_residual(own, constraint, lacking);
  stiffness.fill(kCentre);
  pull.apply<true>(y, z, lacking, stiffness);
  const Row mask = kLaneMasks.of[active];
  moved[0] = moved[kHaloSide - 1] = 0.0f;
  for (int i = 0; i < kBrickSide; ++i) moved[i + 1] = mask[i] * (lacking[i + 1] / stiffness[i + 1]);
  Row place;
  for (int i = 0; i < kBrickSide; ++i) place[i] = own[i] + moved[i + 1];
  std::memcpy(own, place.data(), sizeof(place));
  pull.follow(y, z, moved);
}

/// Rows in four colours by the parities of y and z, to and fro. Rows of one colour do not see each
/// other, so the processor need not wait for one before it starts the next.
CORNICE_CLONES
void relax_brick(Halo& halo, const Equations& equations, Pull& pull) {
  pull.start(halo, equations);
  constexpr std::array<int, 7> order{0, 1, 2, 3, 2, 1, 0};
  for (const int colour : order) {
    for (int z = colour >> 1; z < kBrickSide; z += 2) {
      for (int y = colour & 1; y < kBrickSide; y += 2) {
        const int r = y + kBrickSide * z;
        const std::uint8_t active = (*equations.active)[r];
        if (active)
          relax_row(halo.row(y, z), equations.constraints + kBrickSide * r, y, z, active, pull);
      }
    }
  }
}

CORNICE_CLONES
void brick_residual(const Halo& halo, const Equations& equations, Pull& pull, double& left,
                    double& zero) {
  pull.start(halo, equations);
  for (int r = 0; r < kBrickRows; ++r) {
    const std::uint8_t active = (*equations.active)[r];
    if (active == 0) continue;
    const float* constraint = equations.constraints + kBrickSide * r;
    WideRow lacking, unused;
    row_residual(halo.row(r & 7, r >> 3), constraint, lacking);
    pull.apply<false>(r & 7, r >> 3, lacking, unused);
    const float* mask = kLaneMasks.of[active].data();
    float l = 0.0f, z = 0.0f;
    for (int i = 0; i < kBrickSide; ++i) {
      l += mask[i] * (lacking[i + 1] * lacking[i + 1]);
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

void relax(Grid& grid, const std::vector<float>& right_side, const Screening& screening, int passes,
           int threads) {
  const auto colour = colours(grid);
  for (int pass = 0; pass < passes; ++pass) {
    for (int c = 0; c < 8; ++c) {
      // To and fro, so that no colour always comes last.
      const std::vector<std::uint32_t>& bricks = colour[pass % 2 == 0 ? c : 7 - c];
      parallel_for(bricks.size(), kBricksAtATime, threads, [&](std::size_t begin, std::size_t end) {
        Halo halo;
        Pull pull;
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t b = bricks[i];
          const Equations equations(grid, right_side, screening, b);
          load(grid, b, equations, halo);
          relax_brick(halo, equations, pull);
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
        Pull pull;
        for (std::size_t b = begin; b < end; ++b) {
          const Equations equations(grid, grid.constraints, screening, b);
          load(grid, b, equations, halo);
          brick_residual(halo, equations, pull, part.left, part.zero);
        }
        return part;
      },
      [](Sums& sum, const Sums& part) { sum.left += part.left, sum.zero += part.zero; });
  const double count = std::max<double>(1.0, static_cast<double>(count_active(grid)));
  return {std::sqrt(sums.left / count), std::sqrt(sums.zero / count)};
}

}  // namespace cornice::poisson
