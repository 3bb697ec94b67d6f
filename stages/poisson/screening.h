// SPDX-License-Identifier: GPL-3.0-or-later
// The term that holds the field at zero where the samples are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stages/poisson/grid.h"
#include "stages/poisson/samples.h"

namespace cornice::poisson {

/// A sample as a brick's nodes see it. Its cell is one of the brick's, or of those one before.
struct Tie {
  Vec3f fraction;          ///< place within the cell
  float strength = 0.0f;   ///< of the pull, over the spacing
  std::int8_t x = 0;       ///< cell, -1 .. 7
  std::uint8_t row = 0;    ///< of cells: (y + 1) + 9 (z + 1)
  bool inherited = false;  ///< a finer level has the sample, too
};

inline constexpr int kTieSide = kBrickSide + 1;
inline constexpr int kTieRows = kTieSide * kTieSide;
inline constexpr int kTiesMax = kTieRows * kTieSide;

/// What samples pull with.
enum class Hold {
  kLoose,  ///< kLoosePull of their area
  kOwn,    ///< their pull
};

/// Sum over samples of weight * pull * B_i * B_j, over the spacing, held as the samples themselves:
/// an eighth of what its 27 coefficients a node would take.
/// Kazhdan & Hoppe 2013, equation (6): with weights that grow by 2 from level to level and areas in
/// squared spacings, the same number serves every level.
class Screening {
 public:
  Screening(const Grid& grid, const SampleLevel& samples, float weight, Hold hold, int threads);

  /// From now on with the samples' own pull; they must be the ones that it was made of.
  void hold_with_pull(const Grid& grid, const SampleLevel& samples, float weight, int threads);

  /// Of a brick, by row, then x; no cell twice.
  std::span<const Tie> ties(std::size_t brick) const {
    return {ties_.data() + first_[brick], ties_.data() + first_[brick + 1]};
  }
  /// Number of a brick's first tie among all.
  std::size_t first(std::size_t brick) const { return first_[brick]; }
  /// Ties of all bricks.
  std::size_t size() const { return ties_.size(); }

 private:
  std::vector<std::uint64_t> first_;
  std::vector<Tie> ties_;
};

}  // namespace cornice::poisson
