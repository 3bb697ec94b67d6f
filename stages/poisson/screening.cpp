// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/screening.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 64;

/// Rows with an active node that a sample's functions reach.
std::uint64_t reached_rows(const SampleLevel& samples, BrickKey brick, const RowMasks& active) {
  std::array<std::uint32_t, kBrickRows> reached{};
  for_each_sample_near(samples, brick, -1, kBrickSide - 1, [&](const Sample&, int x, int y, int z) {
    const std::uint32_t nodes = x < 0 ? 1u : 3u << x;
    for (int o = 0; o < 4; ++o) {
      const int j = y + (o & 1), k = z + (o >> 1);
      if (j >= 0 && j < kBrickSide && k >= 0 && k < kBrickSide)
        reached[j + kBrickSide * k] |= nodes;
    }
  });
  std::uint64_t rows = 0;
  for (int r = 0; r < kBrickRows; ++r) {
    if (reached[r] & active[r]) rows |= std::uint64_t{1} << r;
  }
  return rows;
}

/// The eight functions of a sample's cell at the sample, corner o at (o & 1, o >> 1 & 1, o >> 2).
std::array<float, 8> functions(Vec3f f) {
  std::array<float, 8> value;
  for (int o = 0; o < 8; ++o) {
    value[o] =
        (o & 1 ? f.x : 1.0f - f.x) * (o >> 1 & 1 ? f.y : 1.0f - f.y) * (o >> 2 ? f.z : 1.0f - f.z);
  }
  return value;
}

/// Tap of corner `to` seen from corner `from`.
constexpr int tap(int from, int to) {
  return 13 + ((to & 1) - (from & 1)) + 3 * ((to >> 1 & 1) - (from >> 1 & 1)) +
         9 * ((to >> 2) - (from >> 2));
}

}  // namespace

Screening::Screening(const Grid& grid, const SampleLevel& samples, float weight, int threads)
    : rows_(grid.bricks.size()), first_(grid.bricks.size() + 1) {
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t b = begin; b < end; ++b)
                   rows_[b] = reached_rows(samples, grid.bricks[b], grid.active[b]);
               });
  for (std::size_t b = 0; b < rows_.size(); ++b)
    first_[b + 1] = first_[b] + static_cast<std::uint64_t>(std::popcount(rows_[b]));
  taps_ = std::make_unique_for_overwrite<float[]>(first_.back() * kRowFloats);
  parallel_for(
      grid.bricks.size(), kBricksAtATime, threads, [&](std::size_t begin, std::size_t end) {
        std::fill(taps_.get() + first_[begin] * kRowFloats, taps_.get() + first_[end] * kRowFloats,
                  0.0f);
        for (std::size_t b = begin; b < end; ++b) {
          if (rows_[b] == 0) continue;
          std::array<float*, kBrickRows> to{};
          for (int r = 0; r < kBrickRows; ++r) {
            if (has_row(b, r)) to[r] = const_cast<float*>(row(b, r));
          }
          for_each_sample_near(samples, grid.bricks[b], -1, kBrickSide - 1,
                               [&](const Sample& s, int x, int y, int z) {
                                 const std::array<float, 8> value = functions(s.fraction);
                                 const float strength = weight * s.area;
                                 for (int o = 0; o < 8; ++o) {
                                   const int i = x + (o & 1), j = y + (o >> 1 & 1),
                                             k = z + (o >> 2);
                                   if (((i | j | k) & ~7) != 0 || to[j + kBrickSide * k] == nullptr)
                                     continue;
                                   float* taps = to[j + kBrickSide * k] + i;
                                   const float scaled = strength * value[o];
                                   for (int p = 0; p < 8; ++p)
                                     taps[kBrickSide * tap(o, p)] += scaled * value[p];
                                 }
                               });
        }
      });
}

}  // namespace cornice::poisson
