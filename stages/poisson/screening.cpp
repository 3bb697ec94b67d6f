// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/screening.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/base/parallel.h"
#include "stages/poisson/misfit.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 64;

/// The samples that a brick's nodes see, by row of cells, then x.
class SamplesInRows {
 public:
  SamplesInRows(const SampleLevel& samples, BrickKey brick) {
    for_each_sample_near(samples, brick, -1, kBrickSide - 1,
                         [&](const Sample& s, int x, int y, int z) {
                           const int cell = (x + 1) + kTieSide * ((y + 1) + kTieSide * (z + 1));
                           samples_[cell] = &s;
                           there_[cell >> 6] |= std::uint64_t{1} << (cell & 63);
                         });
  }
  /// Calls use(sample, x, row).
  template <class Use>
  void for_each(Use use) const {
    for (int word = 0; word < kWords; ++word) {
      for (std::uint64_t left = there_[word]; left != 0; left &= left - 1) {
        const int cell = 64 * word + std::countr_zero(left);
        use(*samples_[cell], cell % kTieSide - 1, cell / kTieSide);
      }
    }
  }

 private:
  static constexpr int kWords = (kTiesMax + 63) / 64;
  std::array<const Sample*, kTiesMax> samples_;  ///< where there_ says so
  std::array<std::uint64_t, kWords> there_{};
};

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
  parallel_for(
      grid.bricks.size(), kBricksAtATime, threads, [&](std::size_t begin, std::size_t end) {
        Part& part = parts[begin / kBricksAtATime];
        for (std::size_t b = begin; b < end; ++b) {
          const std::size_t before = part.ties.size();
          SamplesInRows(samples, grid.bricks[b]).for_each([&](const Sample& s, int x, int row) {
            const float pull = hold == Hold::kLoose ? kLoosePull * s.area : s.pull;
            part.ties.push_back({s.fraction, weight * pull, static_cast<std::int8_t>(x),
                                 static_cast<std::uint8_t>(row), s.inherited != 0});
          });
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

void Screening::hold_with_pull(const Grid& grid, const SampleLevel& samples, float weight,
                               int threads) {
  if (ties_.empty()) return;
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t b = begin; b < end; ++b) {
                   Tie* tie = ties_.data() + first_[b];
                   SamplesInRows(samples, grid.bricks[b]).for_each([&](const Sample& s, int, int) {
                     (tie++)->strength = weight * s.pull;
                   });
                 }
               });
}

}  // namespace cornice::poisson
