// SPDX-License-Identifier: GPL-3.0-or-later
// The term that holds the field at zero where the samples are.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "stages/poisson/grid.h"
#include "stages/poisson/samples.h"

namespace cornice::poisson {

/// What a node's equation takes of the 27 nodes around it, for the rows of nodes near samples.
class Screening {
 public:
  static constexpr int kTaps = 27;  ///< x fastest; 13 is the node itself
  static constexpr int kRowFloats = kTaps * kBrickSide;

  /// Sum over samples of weight * area * B_i * B_j, over the spacing.
  /// Kazhdan & Hoppe 2013, equation (6): with weights that grow by 2 from level to level and areas
  /// in squared spacings, the same number serves every level.
  Screening(const Grid& grid, const SampleLevel& samples, float weight, int threads);

  bool has_row(std::size_t brick, int row) const { return rows_[brick] >> row & 1; }
  /// 8 values for each tap. Only where has_row.
  const float* row(std::size_t brick, int row) const {
    const std::uint64_t before = rows_[brick] & ((std::uint64_t{1} << row) - 1);
    return taps_.get() +
           (first_[brick] + static_cast<std::uint64_t>(std::popcount(before))) * kRowFloats;
  }

 private:
  std::vector<std::uint64_t> rows_;   ///< one bit per row
  std::vector<std::uint64_t> first_;  ///< number of the brick's first row
  std::unique_ptr<float[]> taps_;
};

}  // namespace cornice::poisson
