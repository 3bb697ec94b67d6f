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
  std::span<const Tie> ties;
  int low = kBrickSide, high = -1;  ///< planes with active nodes

  Equations(const Grid& grid, const Screening& screening, std::size_t brick)
      : constraints(grid.constraints.data() + brick * kBrickNodes),
        active(&grid.active[brick]),
        ties(screening.ties(brick)) {
    for (int r = 0; r < kBrickRows; ++r) {
      if ((*active)[r] == 0) continue;
      low = std::min(low, r >> 3);
      high = r >> 3;
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
/// A row and the node before and behind it, which ties of the cells there also name.
using WideRow = std::array<float, kSide>;

/// How a brick's ties pull. The field at each is kept up to date as nodes move, so that a row costs
/// its own ties only.
class Pull {
 public:
  void start(const Halo& halo, const Equations& equations) {
    ties_ = equations.ties;
    std::size_t t = 0;
    for (int row = 0; row <= kTieRows; ++row) {
      while (t < ties_.size() && ties_[t].row < row) ++t;
      first_[row] = static_cast<std::uint16_t>(t);
    }
    for (t = 0; t < ties_.size(); ++t) {
      const Tie& tie = ties_[t];
      const int y = tie.row % kTieSide - 1, z = tie.row / kTieSide - 1;
      const Vec3f f = tie.fraction;
      const auto along = [&](int j, int k) {
        const float* own = halo.row(y + j, z + k) + tie.x;
        return (1.0f - f.x) * own[0] + f.x * own[1];
      };
      field_[t] = (1.0f - f.z) * ((1.0f - f.y) * along(0, 0) + f.y * along(1, 0)) +
                  f.z * ((1.0f - f.y) * along(0, 1) + f.y * along(1, 1));
    }
  }

  /// Takes the pull off what a row lacks, and, where asked, adds up how it stiffens each node:
  /// ties between nodes of the row are counted with the node itself, as all of them move at once.
  template <bool kStiffness>
  void apply(int y, int z, WideRow& lacking, WideRow& stiffness) const {
    for_each(y, z, [&](std::size_t t, const Tie& tie, float yz) {
      const float pull = tie.strength * yz;
      const float right = tie.fraction.x, left = 1.0f - right;
      const std::size_t i = static_cast<std::size_t>(tie.x + 1);
      lacking[i] -= pull * left * field_[t];
      lacking[i + 1] -= pull * right * field_[t];
      if constexpr (kStiffness) {
        stiffness[i] += pull * yz * left;
        stiffness[i + 1] += pull * yz * right;
      }
    });
  }

  /// The nodes of a row have moved.
  void follow(int y, int z, const WideRow& moved) {
    for_each(y, z, [&](std::size_t t, const Tie& tie, float yz) {
      const float right = tie.fraction.x;
      const std::size_t i = static_cast<std::size_t>(tie.x + 1);
      field_[t] += yz * ((1.0f - right) * moved[i] + right * moved[i + 1]);
    });
  }

 private:
  /// Calls use(index, tie, weight of the row in the tie) for the ties of the four rows of cells
  /// around a row of nodes.
  template <class Use>
  void for_each(int y, int z, Use use) const {
    for (int o = 0; o < 4; ++o) {
      const int above_y = o & 1, above_z = o >> 1;
      const int row = (y + above_y) + kTieSide * (z + above_z);
      for (std::size_t t = first_[row]; t < first_[row + 1]; ++t) {
        const Vec3f f = ties_[t].fraction;
        use(t, ties_[t], (above_y ? 1.0f - f.y : f.y) * (above_z ? 1.0f - f.z : f.z));
      }
    }
  }

  std::span<const Tie> ties_;
  std::array<std::uint16_t, kTieRows + 1> first_;
  std::array<float, kTiesMax> field_;
};

/// What the equations of one row's nodes lack but for screening: constraint less stiffness applied
/// to the values. The first and last entries are zero.
inline void row_residual(const float* own, const float* constraint, WideRow& lacking) {
  const float *a = own - kRow, *b = own + kRow, *c = own - kPlane, *d = own + kPlane;
  const float *e = c - kRow, *f = c + kRow, *g = d - kRow, *h = d + kRow;
  lacking[0] = lacking[kSide - 1] = 0.0f;
  for (int i = 0; i < kBrickSide; ++i) {
    const float edges = ((a[i - 1] + a[i + 1]) + (b[i - 1] + b[i + 1])) +
                        ((c[i - 1] + c[i + 1]) + (d[i - 1] + d[i + 1])) +
                        ((e[i] + f[i]) + (g[i] + h[i]));
    const float corners = ((e[i - 1] + e[i + 1]) + (f[i - 1] + f[i + 1])) +
                          ((g[i - 1] + g[i + 1]) + (h[i - 1] + h[i + 1]));
    lacking[i + 1] = (constraint[i] - kCentre * own[i]) + (kEdge * edges + kCorner * corners);
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
  moved[0] = moved[kSide - 1] = 0.0f;
  for (int i = 0; i < kBrickSide; ++i) moved[i + 1] = mask[i] * (lacking[i + 1] / stiffness[i + 1]);
  Row place;
  for (int i = 0; i < kBrickSide; ++i) place[i] = own[i] + moved[i + 1];
  std::memcpy(own, place.data(), sizeof(place));
  pull.follow(y, z, moved);
}

/// Rows in four colours by the parities of y and z, to and fro. Rows of one colour do not see each
/// other, so the processor need not wait for one before it starts the next.
CORNICE_VECTOR_CLONES
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

CORNICE_VECTOR_CLONES
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

void relax(Grid& grid, const Screening& screening, int passes, int threads) {
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
          const Equations equations(grid, screening, b);
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
          const Equations equations(grid, screening, b);
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
