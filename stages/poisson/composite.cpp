// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/composite.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/clones.h"
#include "core/base/parallel.h"
#include "stages/poisson/equations.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 64;
using Nodes = std::array<float, kBrickNodes>;

/// Which ties of a brick take part.
enum class Ties { kAll, kOwn, kInherited };

/// The field at a brick's ties. `halo` holds the values.
void read_ties(const Halo& halo, std::span<const Tie> ties, float* field) {
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const Tie& tie = ties[t];
    const int y = tie.row % kTieSide - 1, z = tie.row / kTieSide - 1;
    const Vec3f f = tie.fraction;
    const auto along = [&](int j, int k) {
      const float* own = halo.row(y + j, z + k) + tie.x;
      return (1.0f - f.x) * own[0] + f.x * own[1];
    };
    field[t] = (1.0f - f.z) * ((1.0f - f.y) * along(0, 0) + f.y * along(1, 0)) +
               f.z * ((1.0f - f.y) * along(0, 1) + f.y * along(1, 1));
  }
}

/// Adds the pull of a brick's ties to its nodes.
void add_pull(std::span<const Tie> ties, const float* field, Ties which, Nodes& nodes) {
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const Tie& tie = ties[t];
    if (which != Ties::kAll && tie.inherited != (which == Ties::kInherited)) continue;
    const int x = tie.x, y = tie.row % kTieSide - 1, z = tie.row / kTieSide - 1;
    const Vec3f f = tie.fraction;
    const float pull = tie.strength * field[t];
    for (int o = 0; o < 8; ++o) {
      const int i = x + (o & 1), j = y + (o >> 1 & 1), k = z + (o >> 2);
      if (i < 0 || i >= kBrickSide || j < 0 || j >= kBrickSide || k < 0 || k >= kBrickSide)
        continue;
      nodes[i + kBrickSide * (j + kBrickSide * k)] +=
          pull * ((o & 1 ? f.x : 1.0f - f.x) * (o >> 1 & 1 ? f.y : 1.0f - f.y) *
                  (o >> 2 ? f.z : 1.0f - f.z));
    }
  }
}

std::vector<float> fields_at_ties(const Grid& grid, const Screening& screening, int threads) {
  std::vector<float> fields(screening.size());
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 Halo halo;
                 for (std::size_t b = begin; b < end; ++b) {
                   const std::span<const Tie> ties = screening.ties(b);
                   if (ties.empty()) continue;
                   load_stored(grid, b, -1, kBrickSide, halo);
                   read_ties(halo, ties, fields.data() + screening.first(b));
                 }
               });
  return fields;
}

/// Replaces the values of nodes that the coarser level has not by what they differ from its
/// interpolation. Those it has are read, so bricks need not wait for each other.
void to_details(Grid& grid, int threads) {
  parallel_for(
      grid.bricks.size(), kBricksAtATime, threads, [&](std::size_t begin, std::size_t end) {
        Halo halo;
        for (std::size_t b = begin; b < end; ++b) {
          load_stored(grid, b, 0, kBrickSide, halo);
          float* to = grid.values.data() + b * kBrickNodes;
          for (int n = 0; n < kBrickNodes; ++n) {
            const int x = n & 7, y = n >> 3 & 7, z = n >> 6;
            if (is_even(n)) continue;
            if ((grid.active[b][n >> 3] >> x & 1) == 0) {
              to[n] = 0.0f;
              continue;
            }
            float sum = 0.0f;
            for (int o = 0; o < 8; ++o)
              sum += halo.row((y & ~1) + (o >> 1 & 1) * 2 * (y & 1),
                              (z & ~1) + (o >> 2) * 2 * (z & 1))[(x & ~1) + (o & 1) * 2 * (x & 1)];
            to[n] -= 0.125f * sum;
          }
        }
      });
}

/// Stiffness applied to the details around a brick.
CORNICE_CLONES
void add_stiffness(Halo& details, Nodes& nodes) {
  for (int z = 0; z <= kBrickSide; z += 2) {
    for (int y = 0; y <= kBrickSide; y += 2) {
      float* row = details.row(y, z);
      for (int x = 0; x <= kBrickSide; x += 2) row[x] = 0.0f;
    }
  }
  constexpr Row none{};
  for (int r = 0; r < kBrickRows; ++r) {
    WideRow lacking;
    row_residual(details.row(r & 7, r >> 3), none.data(), lacking);
    for (int i = 0; i < kBrickSide; ++i) nodes[kBrickSide * r + i] -= lacking[i + 1];
  }
}

constexpr int kHalf = kBrickSide / 2 + 1;
using CoarseNodes = std::array<float, kHalf * kHalf * kHalf>;

/// Half the sums over a fine brick's nodes with the weights (1, 2, 1) / 2 on each axis: its part in
/// the coarse nodes it reaches. As in constraints.cpp.
CORNICE_CLONES
void restrict_brick(const Nodes& fine, CoarseNodes& coarse) {
  std::array<float, kHalf * kBrickSide * kBrickSide> x{};
  for (int r = 0; r < kBrickRows; ++r) {
    const float* from = fine.data() + kBrickSide * r;
    float* to = x.data() + kHalf * r;
    for (int i = 0; i < kBrickSide / 2; ++i) {
      to[i] += from[2 * i] + 0.5f * from[2 * i + 1];
      to[i + 1] += 0.5f * from[2 * i + 1];
    }
  }
  std::array<float, kHalf * kHalf * kBrickSide> xy{};
  for (int k = 0; k < kBrickSide; ++k) {
    for (int j = 0; j < kBrickSide; ++j) {
      const float* from = x.data() + kHalf * (j + kBrickSide * k);
      float* to = xy.data() + kHalf * (j / 2 + kHalf * k);
      for (int i = 0; i < kHalf; ++i) {
        if ((j & 1) == 0) {
          to[i] += from[i];
        } else {
          to[i] += 0.5f * from[i];
          to[i + kHalf] += 0.5f * from[i];
        }
      }
    }
  }
  constexpr int kPlane = kHalf * kHalf;
  coarse.fill(0.0f);
  for (int k = 0; k < kBrickSide; ++k) {
    const float* from = xy.data() + kPlane * k;
    float* to = coarse.data() + kPlane * (k / 2);
    for (int i = 0; i < kPlane; ++i) {
      if ((k & 1) == 0) {
        to[i] += 0.5f * from[i];
      } else {
        to[i] += 0.25f * from[i];
        to[i + kPlane] += 0.25f * from[i];
      }
    }
  }
}

/// Adds a child's part to the coarse brick and the ones behind it.
void scatter(const CoarseNodes& part, int octant, const Neighbours& around,
             std::vector<float>& right_side) {
  const int x0 = 4 * (octant & 1), y0 = 4 * (octant >> 1 & 1), z0 = 4 * (octant >> 2);
  for (int k = 0; k < kHalf; ++k) {
    for (int j = 0; j < kHalf; ++j) {
      for (int i = 0; i < kHalf; ++i) {
        const int x = x0 + i, y = y0 + j, z = z0 + k;
        const std::uint32_t owner = around[kItself + (x >> 3) + 3 * (y >> 3) + 9 * (z >> 3)];
        if (owner == BrickIndex::kNone) continue;
        const int node = (x & 7) | (y & 7) << 3 | (z & 7) << 6;
        right_side[std::size_t{owner} * kBrickNodes + static_cast<std::size_t>(node)] +=
            part[i + kHalf * (j + kHalf * k)];
      }
    }
  }
}

/// Nodes that both levels have.
void inject(const float* fine, int octant, float* coarse) {
  const int x0 = 4 * (octant & 1), y0 = 4 * (octant >> 1 & 1), z0 = 4 * (octant >> 2);
  for (int z = 0; z < 4; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 4; ++x)
        coarse[x0 + x + kBrickSide * (y0 + y + kBrickSide * (z0 + z))] =
            fine[2 * (x + kBrickSide * (y + kBrickSide * z))];
    }
  }
}

/// Adds to coarse.right_side what the finer levels' part in the equations is. `fine` holds details.
void restrict_level(const Grid& fine, const Screening& screening, const std::vector<float>& fields,
                    bool fine_is_finest, Grid& coarse, int threads) {
  std::array<std::vector<std::uint32_t>, 8> colours;
  for (std::uint32_t b = 0; b < coarse.bricks.size(); ++b) {
    const BrickKey key = coarse.bricks[b];
    colours[(key.x & 1) | (key.y & 1) << 1 | (key.z & 1) << 2].push_back(b);
  }
  for (const std::vector<std::uint32_t>& colour : colours) {
    parallel_for(colour.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
      Nodes nodes;
      CoarseNodes part;
      for (std::size_t c = begin; c < end; ++c) {
        const std::uint32_t parent = colour[c];
        const BrickKey key = coarse.bricks[parent];
        for (int o = 0; o < 8; ++o) {
          const std::uint32_t b = fine.index.find(
              fine.bricks, {2 * key.x + (o & 1), 2 * key.y + (o >> 1 & 1), 2 * key.z + (o >> 2)});
          if (b == BrickIndex::kNone) continue;
          const std::size_t first = std::size_t{b} * kBrickNodes;
          if (fine_is_finest) {
            nodes.fill(0.0f);
          } else {
            std::copy_n(fine.right_side.data() + first, kBrickNodes, nodes.data());
          }
          Halo halo;
          load_stored(fine, b, -1, kBrickSide, halo);
          add_stiffness(halo, nodes);
          add_pull(screening.ties(b), fields.data() + screening.first(b),
                   fine_is_finest ? Ties::kAll : Ties::kOwn, nodes);
          restrict_brick(nodes, part);
          scatter(part, o, coarse.neighbours[parent], coarse.right_side);
          inject(fine.values.data() + first, o,
                 coarse.values.data() + std::size_t{parent} * kBrickNodes);
        }
      }
    });
  }
}

/// From the finer levels' part to what they leave: constraints less that part, but for the pull
/// that the level itself will count.
void make_right_side(Grid& grid, const Screening& screening, const std::vector<float>& fields,
                     int threads) {
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 Nodes inherited;
                 for (std::size_t b = begin; b < end; ++b) {
                   inherited.fill(0.0f);
                   add_pull(screening.ties(b), fields.data() + screening.first(b), Ties::kInherited,
                            inherited);
                   for (int n = 0; n < kBrickNodes; ++n) {
                     float& side = grid.right_side[b * kBrickNodes + n];
                     side = (grid.constraints[b * kBrickNodes + n] - side) + inherited[n];
                   }
                 }
               });
}

}  // namespace

void raise(Grid& fine, const Screening& fine_screening, Grid& coarse, bool fine_is_finest,
           int threads) {
  const std::vector<float> fields = fields_at_ties(fine, fine_screening, threads);
  to_details(fine, threads);
  coarse.right_side.assign(coarse.bricks.size() * kBrickNodes, 0.0f);
  restrict_level(fine, fine_screening, fields, fine_is_finest, coarse, threads);
  if (!fine_is_finest) make_right_side(fine, fine_screening, fields, threads);
}

void finish_raise(Grid& coarsest, const Screening& screening, int threads) {
  make_right_side(coarsest, screening, fields_at_ties(coarsest, screening, threads), threads);
}

void lower(Grid& fine, std::span<const LevelView> coarser, int threads) {
  prolong_below_details(fine, coarser, threads);
}

}  // namespace cornice::poisson
