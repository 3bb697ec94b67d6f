// SPDX-License-Identifier: GPL-3.0-or-later
// The points, drawn together cell by cell on every level: what the solver works with.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/mesh.h"
#include "stages/poisson/bricks.h"

namespace cornice::poisson {

/// All points of one cell as one (Kazhdan & Hoppe 2013, section 4.2: the mean position stands for
/// the points, with the sum of their weights).
struct Sample {
  Vec3f fraction;          ///< weighted mean position within the cell, 0..1 per axis
  Vec3f normal;            ///< sum of quality times unit normal
  float weight = 0.0f;     ///< sum of quality
  float count = 0.0f;      ///< points, each finest cell counting for at most kCellCountMax
  float area = 0.0f;       ///< of the ground that the cell's points stand for, in squared spacings
  float pull = 0.0f;       ///< area that screening counts, in squared spacings (misfit.h)
  float depth = 0.0f;      ///< the level, not rounded, that suits the points' density; >= 0
  std::uint16_t cell = 0;  ///< within its brick, x fastest
  std::uint8_t dense = 0;  ///< 1 where this level is used, or a finer one
  std::uint8_t inherited = 0;  ///< 1 where a finer one is
};

/// More points than this in one cell say nothing more about how densely the ground is covered: a
/// heap of doubled points must not pass for dense ground.
inline constexpr float kCellCountMax = 3.0f;
/// No finest cell weighs more than this many points of its mean quality: a heap must not take the
/// ground around it away.
inline constexpr float kCellWeightMax = 32.0f;

/// Samples of one level, brick by brick; each cell of a brick at most once, ascending.
struct SampleLevel {
  std::vector<BrickKey> bricks;  ///< sorted
  BrickIndex index;
  std::vector<std::uint64_t> first;  ///< bricks.size() + 1; first sample of each brick
  std::vector<Sample> samples;
};

/// Calls use(sample, x, y, z) for every sample whose cell (x, y, z), counted from the first cell of
/// `brick`, lies in [low, high] on all axes; always in the same order.
template <class Use>
void for_each_sample_near(const SampleLevel& level, BrickKey brick, int low, int high, Use&& use) {
  const auto below = [](int cell) { return cell >= 0 ? cell / kBrickSide : -((7 - cell) / 8); };
  const int b0 = below(low), b1 = below(high);
  for (int bx = b0; bx <= b1; ++bx) {
    for (int by = b0; by <= b1; ++by) {
      for (int bz = b0; bz <= b1; ++bz) {
        const std::uint32_t at = level.index.find(level.bricks, shifted(brick, bx, by, bz));
        if (at == BrickIndex::kNone) continue;
        for (std::uint64_t s = level.first[at]; s < level.first[at + 1]; ++s) {
          const Sample& sample = level.samples[s];
          const int x = 8 * bx + (sample.cell & 7), y = 8 * by + (sample.cell >> 3 & 7),
                    z = 8 * bz + (sample.cell >> 6);
          if (x >= low && x <= high && y >= low && y <= high && z >= low && z <= high)
            use(sample, x, y, z);
        }
      }
    }
  }
}

/// Points that were left out, and why.
struct LeftOut {
  std::uint64_t not_finite = 0;
  std::uint64_t without_normal = 0;
  std::uint64_t outside = 0;
};

/// Samples of the finest level: of the points in `domain` (projected, metres) that are finite and
/// have a normal and a quality above 0. `area`, `depth` and `dense` are not set yet. The same for
/// any number of threads.
SampleLevel gather_samples(const OrientedPoints& points, const Box3d& domain, double step_m,
                           int threads, LeftOut& left_out);

/// Samples of the next coarser level.
SampleLevel coarser_samples(const SampleLevel& finer, int threads);

}  // namespace cornice::poisson
