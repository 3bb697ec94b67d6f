// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/screening.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "stages/poisson/misfit.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 64;

/// Appends a brick's ties, sorted.
void append_ties(const SampleLevel& samples, BrickKey brick, float weight, Hold hold,
                 std::vector<Tie>& ties) {
  const auto begin = static_cast<std::ptrdiff_t>(ties.size());
  for_each_sample_near(
      samples, brick, -1, kBrickSide - 1, [&](const Sample& s, int x, int y, int z) {
        const float pull = hold == Hold::kLoose ? kLoosePull * s.area : s.pull;
        ties.push_back({s.fraction, weight * pull, static_cast<std::int8_t>(x),
                        static_cast<std::uint8_t>((y + 1) + kTieSide * (z + 1)), s.inherited != 0});
      });
  std::sort(ties.begin() + begin, ties.end(),
            [](const Tie& a, const Tie& b) { return a.row != b.row ? a.row < b.row : a.x < b.x; });
}

}  // namespace

Screening::Screening(const Grid& grid, const SampleLevel& samples, float weight, Hold hold,
                     int threads)
    : first_(1, 0) {
  if (weight == 0.0f) {
    first_.resize(grid.bricks.size() + 1, 0);
    return;
  }
  struct Part {
    std::vector<std::uint32_t> counts;
    std::vector<Tie> ties;
  };
  std::vector<Part> parts((grid.bricks.size() + kBricksAtATime - 1) / kBricksAtATime);
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 Part& part = parts[begin / kBricksAtATime];
                 for (std::size_t b = begin; b < end; ++b) {
                   const std::size_t before = part.ties.size();
                   append_ties(samples, grid.bricks[b], weight, hold, part.ties);
                   part.counts.push_back(static_cast<std::uint32_t>(part.ties.size() - before));
                 }
               });
  first_.reserve(grid.bricks.size() + 1);
  for (const Part& part : parts) {
    for (const std::uint32_t count : part.counts) first_.push_back(first_.back() + count);
  }
  ties_.resize(first_.back());
  parallel_for(parts.size(), 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      std::copy(parts[p].ties.begin(), parts[p].ties.end(),
                ties_.begin() + static_cast<std::ptrdiff_t>(first_[p * kBricksAtATime]));
      std::vector<Tie>().swap(parts[p].ties);
    }
  });
}

}  // namespace cornice::poisson
