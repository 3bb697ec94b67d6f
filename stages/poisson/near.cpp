// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/near.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/parallel.h"

namespace cornice::poisson {
namespace {

/// Bricks that are looked at together lie in a row, so that most repetitions fall in one part.
constexpr std::size_t kBricksAtATime = 512;

struct Extent {
  int low = kBrickSide, high = -1;
  void add(int c) { low = std::min(low, c), high = std::max(high, c); }
  /// Cells [first, last] of the brick `d` bricks away reach into it.
  bool meets(int d, int first, int last) const {
    return high >= 8 * d + first && low <= 8 * d + last;
  }
};

void sort_unique(std::vector<BrickKey>& bricks) {
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
}

void append_near(const SampleLevel& level, std::size_t b, int low, int high, bool dense_only,
                 std::vector<BrickKey>& near) {
  Extent x, y, z;
  for (std::uint64_t s = level.first[b]; s < level.first[b + 1]; ++s) {
    const Sample& sample = level.samples[s];
    if (dense_only && sample.dense == 0) continue;
    x.add(sample.cell & 7), y.add(sample.cell >> 3 & 7), z.add(sample.cell >> 6);
  }
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        if (x.meets(dx, low, high) && y.meets(dy, low, high) && z.meets(dz, low, high))
          near.push_back(shifted(level.bricks[b], dx, dy, dz));
      }
    }
  }
}

}  // namespace

std::vector<BrickKey> bricks_near(const SampleLevel& level, int low, int high, bool dense_only,
                                  int threads) {
  std::vector<BrickKey> all = parallel_reduce(
      level.bricks.size(), kBricksAtATime, threads, std::vector<BrickKey>(),
      [&](std::size_t begin, std::size_t end) {
        std::vector<BrickKey> near;
        for (std::size_t b = begin; b < end; ++b)
          append_near(level, b, low, high, dense_only, near);
        sort_unique(near);
        return near;
      },
      [](std::vector<BrickKey>& sum, const std::vector<BrickKey>& part) {
        sum.insert(sum.end(), part.begin(), part.end());
      });
  sort_unique(all);
  return all;
}

}  // namespace cornice::poisson
