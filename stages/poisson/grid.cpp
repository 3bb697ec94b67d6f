// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/grid.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "core/base/parallel.h"
#include "stages/poisson/near.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 64;
/// A cell with samples makes the nodes unknown that are this far from it, corners of the cell
/// counting as 1: one for the splatted normals, one for their divergence, one to even out.
constexpr int kBand = 2;
/// Cells, counted from a brick's first, whose samples reach its nodes, or those one further.
constexpr int kLow = -kBand - 1, kHigh = kBrickSide + kBand - 1;
constexpr int kWide = kHigh - kLow + 1;

/// Cells with samples around a brick; bit x of a row is cell kLow + x.
using CellRows = std::array<std::array<std::uint32_t, kWide>, kWide>;

/// Nodes of a brick that its surrounding cells make unknown. False where they do not even reach
/// the nodes one further.
bool mark_active(const SampleLevel& samples, BrickKey brick, RowMasks& active) {
  CellRows cells{};
  bool any = false;
  for_each_sample_near(samples, brick, kLow, kHigh, [&](const Sample& s, int x, int y, int z) {
    if (s.dense == 0) return;
    any = true;
    cells[z - kLow][y - kLow] |= 1u << (x - kLow);
  });
  if (!any) return false;
  // Node n sees the cells n - kBand .. n + kBand - 1: widen along x, then y, then z.
  CellRows wide{};
  for (int k = 0; k < kWide; ++k) {
    for (int j = 0; j < kWide; ++j) {
      std::uint32_t row = 0;
      for (int d = 0; d < 2 * kBand; ++d) row |= cells[k][j] >> (1 + d);
      for (int d = 0; d < 2 * kBand; ++d) {
        const int y = j + kLow + kBand - d;
        if (y >= 0 && y < kBrickSide) wide[k][y] |= row;
      }
    }
  }
  active.fill(0);
  for (int k = 0; k < kWide; ++k) {
    for (int d = 0; d < 2 * kBand; ++d) {
      const int z = k + kLow + kBand - d;
      if (z < 0 || z >= kBrickSide) continue;
      for (int y = 0; y < kBrickSide; ++y)
        active[y + kBrickSide * z] |= static_cast<std::uint8_t>(wide[k][y]);
    }
  }
  return true;
}

void fill_rest(Grid& grid, int threads) {
  grid.index = BrickIndex(grid.bricks);
  grid.neighbours = find_neighbours(grid.bricks, grid.index, threads);
  grid.values.resize(grid.bricks.size() * kBrickNodes);
  grid.constraints.resize(grid.bricks.size() * kBrickNodes);
}

}  // namespace

std::vector<Neighbours> find_neighbours(std::span<const BrickKey> bricks, const BrickIndex& index,
                                        int threads) {
  std::vector<Neighbours> all(bricks.size());
  parallel_for(bricks.size(), kBricksAtATime, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      for (int n = 0; n < 27; ++n)
        all[b][n] = index.find(bricks, shifted(bricks[b], n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
    }
  });
  return all;
}

Grid make_band(const SampleLevel& samples, int threads) {
  const std::vector<BrickKey> candidates = bricks_near(samples, kLow, kHigh, true, threads);
  Grid grid = parallel_reduce(
      candidates.size(), kBricksAtATime, threads, Grid{},
      [&](std::size_t begin, std::size_t end) {
        Grid part;
        RowMasks active;
        for (std::size_t c = begin; c < end; ++c) {
          if (!mark_active(samples, candidates[c], active)) continue;
          part.bricks.push_back(candidates[c]);
          part.active.push_back(active);
        }
        return part;
      },
      [](Grid& sum, const Grid& part) {
        sum.bricks.insert(sum.bricks.end(), part.bricks.begin(), part.bricks.end());
        sum.active.insert(sum.active.end(), part.active.begin(), part.active.end());
      });
  fill_rest(grid, threads);
  return grid;
}

Grid make_whole(const BrickBox& box, int threads) {
  Grid grid;
  for (int x = box.first.x; x <= box.last.x; ++x) {
    for (int y = box.first.y; y <= box.last.y; ++y) {
      for (int z = box.first.z; z <= box.last.z; ++z) grid.bricks.push_back({x, y, z});
    }
  }
  RowMasks all;
  all.fill(0xff);
  grid.active.assign(grid.bricks.size(), all);
  grid.whole = true;
  fill_rest(grid, threads);
  return grid;
}

std::uint64_t count_active(const Grid& grid) {
  std::uint64_t count = 0;
  for (const RowMasks& rows : grid.active) {
    for (const std::uint8_t row : rows) count += static_cast<std::uint64_t>(std::popcount(row));
  }
  return count;
}

namespace {

/// Calls set(values, interpolated) for every brick, both of 512 nodes.
template <class Set>
void for_each_interpolated(Grid& grid, std::span<const LevelView> coarser, int threads, Set set) {
  std::vector<LevelView> levels{{}};
  const BrickIndex none;
  levels.front().index = &none;
  levels.insert(levels.end(), coarser.begin(), coarser.end());
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 std::array<float, kClosedBrickNodes> closed{};
                 std::array<float, kBrickNodes> owned;
                 for (std::size_t b = begin; b < end; ++b) {
                   const bool covered = read_closed_brick(levels, grid.bricks[b], closed);
                   assert(covered && "the coarsest level covers the domain with a margin");
                   static_cast<void>(covered);
                   for (int i = 0; i < kBrickNodes; ++i)
                     owned[i] = closed[i % 8 + 9 * (i / 8 % 8 + 9 * (i / 64))];
                   set(grid.values.data() + b * kBrickNodes, owned);
                 }
               });
}

}  // namespace

void prolong(Grid& grid, std::span<const LevelView> coarser, int threads) {
  for_each_interpolated(grid, coarser, threads,
                        [](float* values, const std::array<float, kBrickNodes>& owned) {
                          std::copy(owned.begin(), owned.end(), values);
                        });
}

void prolong_below_details(Grid& grid, std::span<const LevelView> coarser, int threads) {
  for_each_interpolated(grid, coarser, threads,
                        [](float* values, const std::array<float, kBrickNodes>& owned) {
                          for (int i = 0; i < kBrickNodes; ++i)
                            values[i] = owned[i] + (is_even(i) ? 0.0f : values[i]);
                        });
}

}  // namespace cornice::poisson
