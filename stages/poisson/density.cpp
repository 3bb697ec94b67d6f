// SPDX-License-Identifier: GPL-3.0-or-later
// Density by kernel, as in M. Kazhdan, M. Bolitho, H. Hoppe, "Poisson surface reconstruction",
// 2006, section 4.4: samples are splatted on a coarse grid with a quadratic B-spline and read back
// with the same. Where too few are seen, the next coarser grid is asked.
#include "stages/poisson/density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "stages/poisson/near.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 32;
/// Finest grid that densities are read from: its cells of 4 steps see 16 columns of finest cells.
constexpr int kFinestKernel = 2;
/// What a plane of one sample per cell face reads as: the integral over a plane through its centre
/// of the spline convolved with itself, nearly the same for every slope and offset.
constexpr float kPlaneValue = 0.55f;
/// A grid that sees fewer samples than the first is not believed, from the second on it is alone.
constexpr float kTooFew = 2.0f, kEnough = 6.0f;
/// Ground in one cell, in squared cell sides; more is a lonely heap of points.
constexpr float kAreaMax = 2.0f;
/// Ground with fewer points per squared finest step than this is sparse. There each point holds the
/// surface more firmly, by up to kSparsePull: noise averages out less than the ground bends between
/// points.
constexpr float kSparse = 3.0f, kSparsePull = 4.0f;

struct Amount {
  float weight = 0.0f, count = 0.0f;
};

/// Sums of weights and counts at the cells' centres of one level.
struct DensityGrid {
  std::vector<BrickKey> bricks;
  BrickIndex index;
  std::vector<Amount> amounts;  ///< 512 a brick
};

/// Quadratic B-spline at the centres of the cell before, of, and after a position.
std::array<float, 3> spline(float fraction) {
  const float left = 1.0f - fraction, middle = fraction - 0.5f;
  return {0.5f * left * left, 0.75f - middle * middle, 0.5f * fraction * fraction};
}

/// Amounts of one brick of a grid, from samples one level finer.
void splat(const SampleLevel& finer, BrickKey brick, Amount* amounts) {
  const BrickKey start{2 * brick.x, 2 * brick.y, 2 * brick.z};
  for_each_sample_near(finer, start, -2, 17, [&](const Sample& s, int x, int y, int z) {
    const int cx = (x + 2) / 2 - 1, cy = (y + 2) / 2 - 1, cz = (z + 2) / 2 - 1;
    const auto wx = spline(0.5f * (s.fraction.x + static_cast<float>(x & 1)));
    const auto wy = spline(0.5f * (s.fraction.y + static_cast<float>(y & 1)));
    const auto wz = spline(0.5f * (s.fraction.z + static_cast<float>(z & 1)));
    for (int k = std::max(cz - 1, 0); k <= std::min(cz + 1, 7); ++k) {
      for (int j = std::max(cy - 1, 0); j <= std::min(cy + 1, 7); ++j) {
        const float yz = wy[j - cy + 1] * wz[k - cz + 1];
        for (int i = std::max(cx - 1, 0); i <= std::min(cx + 1, 7); ++i) {
          Amount& to = amounts[i + 8 * (j + 8 * k)];
          to.weight += wx[i - cx + 1] * yz * s.weight;
          to.count += wx[i - cx + 1] * yz * s.count;
        }
      }
    }
  });
}

DensityGrid make_grid(const SampleLevel& finer, const SampleLevel& level, int threads) {
  DensityGrid grid;
  grid.bricks = bricks_near(level, -1, 8, false, threads);
  grid.index = BrickIndex(grid.bricks);
  grid.amounts.resize(grid.bricks.size() * kBrickNodes);
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t b = begin; b < end; ++b)
                   splat(finer, grid.bricks[b], grid.amounts.data() + b * kBrickNodes);
               });
  return grid;
}

/// The cells of a grid that a brick of a finer level, and one cell around, lie in.
class Window {
 public:
  /// `down` levels lie between the brick's and the grid's: 1 or more.
  Window(const DensityGrid& grid, BrickKey brick, int down) : scale_(std::ldexp(1.0f, -down)) {
    const int shift = 3 - down;  // a brick's first cell, in cells of the grid
    const auto first = [&](std::int32_t b) { return shift >= 0 ? b * (1 << shift) : b >> -shift; };
    const auto rest = [&](std::int32_t b) {
      return shift >= 0 ? 0.0f : static_cast<float>(b - (first(b) * (1 << -shift))) * 8.0f;
    };
    const int x0 = first(brick.x) - 1, y0 = first(brick.y) - 1, z0 = first(brick.z) - 1;
    rest_ = {rest(brick.x), rest(brick.y), rest(brick.z)};
    side_ = (shift >= 0 ? 1 << shift : 1) + 2;
    BrickKey last{};
    std::uint32_t at = BrickIndex::kNone;
    for (int k = 0; k < side_; ++k) {
      for (int j = 0; j < side_; ++j) {
        for (int i = 0; i < side_; ++i) {
          const BrickKey owner{(x0 + i) >> 3, (y0 + j) >> 3, (z0 + k) >> 3};
          if (at == BrickIndex::kNone || owner != last) {
            at = grid.index.find(grid.bricks, owner);
            last = owner;
          }
          if (at == BrickIndex::kNone) continue;
          const int cell = ((x0 + i) & 7) | ((y0 + j) & 7) << 3 | ((z0 + k) & 7) << 6;
          amounts_[i + 6 * (j + 6 * k)] =
              grid.amounts[std::size_t{at} * kBrickNodes + static_cast<std::size_t>(cell)];
        }
      }
    }
  }

  /// At a place in the brick, counted in cells of the brick's level.
  Amount read(Vec3f place) const {
    const auto axis = [&](float c, float rest) {
      const float p = (c + rest) * scale_;
      const int cell = std::min(static_cast<int>(p), side_ - 3);
      return std::pair(cell, spline(p - static_cast<float>(cell)));
    };
    const auto [cx, wx] = axis(place.x, rest_.x);
    const auto [cy, wy] = axis(place.y, rest_.y);
    const auto [cz, wz] = axis(place.z, rest_.z);
    Amount sum;
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) {
        const float yz = wy[j] * wz[k];
        for (int i = 0; i < 3; ++i) {
          const Amount& at = amounts_[(cx + i) + 6 * ((cy + j) + 6 * (cz + k))];
          sum.weight += wx[i] * yz * at.weight;
          sum.count += wx[i] * yz * at.count;
        }
      }
    }
    return sum;
  }

 private:
  float scale_;
  Vec3f rest_;
  int side_ = 0;
  std::array<Amount, 6 * 6 * 6> amounts_{};
};

/// Samples and weight per squared finest step around places of one brick.
class BrickDensity {
 public:
  BrickDensity(const std::vector<DensityGrid>& grids, int level, BrickKey brick)
      : grids_(grids), level_(level), brick_(brick), windows_(grids.size()) {}

  Amount at(Vec3f place) {
    const int last = static_cast<int>(grids_.size()) - 1;
    Amount density;
    float missing = 1.0f;
    for (int k = std::max(kFinestKernel, level_ + 1); missing > 0.0f; ++k) {
      k = std::min(k, last);
      auto& window = windows_[static_cast<std::size_t>(k)];
      if (!window) window.emplace(grids_[static_cast<std::size_t>(k)], brick_, k - level_);
      const Amount seen = window->read(place);
      const float trust =
          k == last
              ? 1.0f
              : std::clamp((seen.count / kPlaneValue - kTooFew) / (kEnough - kTooFew), 0.0f, 1.0f);
      const float scale = missing * trust / (kPlaneValue * std::ldexp(1.0f, 2 * k));
      density.weight += scale * seen.weight;
      density.count += scale * seen.count;
      missing *= 1.0f - trust;
    }
    return density;
  }

 private:
  const std::vector<DensityGrid>& grids_;
  int level_;
  BrickKey brick_;
  std::vector<std::optional<Window>> windows_;
};

void apply(SampleLevel& level, int number, const std::vector<DensityGrid>& grids,
           double points_per_cell, int threads) {
  parallel_for(
      level.bricks.size(), kBricksAtATime, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
          BrickDensity density(grids, number, level.bricks[b]);
          for (std::uint64_t i = level.first[b]; i < level.first[b + 1]; ++i) {
            Sample& s = level.samples[i];
            const Amount around = density.at(
                s.fraction + Vec3<int>{s.cell & 7, s.cell >> 3 & 7, s.cell >> 6}.cast<float>());
            const float area = s.weight / around.weight * std::ldexp(1.0f, -2 * number);
            s.area = std::min(area, kAreaMax);
            s.pull = s.area * std::clamp(kSparse / around.weight, 1.0f, kSparsePull);
            s.depth = std::max(
                0.0f, 0.5f * std::log2(static_cast<float>(points_per_cell) / around.count));
            s.dense = s.depth < static_cast<float>(number + 1) ? 1 : 0;
          }
        }
      });
}

/// A cell is used where a finer one in it is.
void inherit_dense(const SampleLevel& finer, SampleLevel& level, int threads) {
  parallel_for(level.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t b = begin; b < end; ++b) {
                   std::array<std::uint8_t, kBrickNodes> dense{};
                   const BrickKey key = level.bricks[b];
                   for_each_sample_near(finer, {2 * key.x, 2 * key.y, 2 * key.z}, 0, 15,
                                        [&](const Sample& s, int x, int y, int z) {
                                          if (s.dense)
                                            dense[(x >> 1) | (y >> 1) << 3 | (z >> 1) << 6] = 1;
                                        });
                   for (std::uint64_t i = level.first[b]; i < level.first[b + 1]; ++i) {
                     Sample& s = level.samples[i];
                     if (dense[s.cell]) s.dense = s.inherited = 1;
                   }
                 }
               });
}

}  // namespace

void estimate_density(std::vector<SampleLevel>& levels, double points_per_cell, int threads) {
  // One grid beyond the last level: every level reads from a coarser one.
  std::vector<DensityGrid> grids(std::max<std::size_t>(levels.size(), kFinestKernel) + 1);
  std::vector<SampleLevel> beyond;
  const auto level_at = [&](std::size_t l) -> const SampleLevel& {
    return l < levels.size() ? levels[l] : beyond[l - levels.size()];
  };
  for (std::size_t l = levels.size(); l < grids.size(); ++l)
    beyond.push_back(coarser_samples(level_at(l - 1), threads));
  for (std::size_t k = kFinestKernel; k < grids.size(); ++k)
    grids[k] = make_grid(level_at(k - 1), level_at(k), threads);
  for (std::size_t l = 0; l < levels.size(); ++l)
    apply(levels[l], static_cast<int>(l), grids, points_per_cell, threads);
  for (std::size_t l = 1; l < levels.size(); ++l) inherit_dense(levels[l - 1], levels[l], threads);
}

}  // namespace cornice::poisson
