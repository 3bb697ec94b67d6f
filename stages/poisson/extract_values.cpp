// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "stages/poisson/extract.h"

namespace cornice {
namespace {

/// Bricks of level 0 above and below which no level of the field has anything.
struct HeightRange {
  std::int32_t first = 0, last = -1;
};

HeightRange height_range(const Field& field) {
  HeightRange range;
  bool any = false;
  for (std::size_t level = 0; level < field.levels().size(); ++level) {
    for (const BrickKey brick : field.levels()[level].bricks) {
      const std::int32_t low = brick.z * (std::int32_t{1} << level);
      const std::int32_t high = (brick.z + 1) * (std::int32_t{1} << level) - 1;
      range.first = any ? std::min(range.first, low) : low;
      range.last = any ? std::max(range.last, high) : high;
      any = true;
    }
  }
  return range;
}

}  // namespace

const float* FieldValues::stored(BrickKey brick) const {
  if (field_->levels().empty() || !is_known(brick)) return nullptr;
  const std::uint32_t at = field_->find(0, brick);
  if (at == BrickIndex::kNone) return nullptr;
  return field_->levels()[0].values.data() + std::size_t{at} * kBrickNodes;
}

bool FieldValues::compute(BrickKey brick, std::span<float, kBrickNodes> values) const {
  std::array<float, kClosedBrickNodes> closed;
  if (!is_known(brick) || !field_->closed_brick(0, brick, closed)) return false;
  constexpr int kClosed = kBrickSide + 1;
  for (int k = 0; k < kBrickSide; ++k) {
    for (int j = 0; j < kBrickSide; ++j) {
      std::copy_n(closed.data() + kClosed * (j + kClosed * k), kBrickSide,
                  values.data() + kBrickSide * (j + kBrickSide * k));
    }
  }
  return true;
}

std::vector<BrickKey> FieldValues::crossing_bricks(BrickKey first, BrickKey last,
                                                   int threads) const {
  const HeightRange range = height_range(*field_);
  first.z = std::max(range.first, first_z_), last.z = std::min(range.last, last_z_);
  if (first.z > last.z) return {};
  return field_->crossing_bricks(first, last, threads);
}

}  // namespace cornice
