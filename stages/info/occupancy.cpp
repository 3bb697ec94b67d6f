// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/info/occupancy.h"

#include <bit>
#include <cmath>
#include <utility>

namespace cornice::info {
namespace {

using Blocks = std::unordered_map<std::uint64_t, std::uint64_t>;

/// Blocks before cells are made coarser: 64 million cells, some 40 MB.
constexpr std::size_t kMostBlocks = std::size_t{1} << 20;
constexpr std::int64_t kBias = std::int64_t{1} << 31;

std::uint64_t key_of(std::int64_t x, std::int64_t y) {
  return (static_cast<std::uint64_t>(x + kBias) << 32) |
         (static_cast<std::uint64_t>(y + kBias) & 0xffffffffu);
}
std::int64_t x_of(std::uint64_t key) { return static_cast<std::int64_t>(key >> 32) - kBias; }
std::int64_t y_of(std::uint64_t key) {
  return static_cast<std::int64_t>(key & 0xffffffffu) - kBias;
}

void set(Blocks& blocks, std::int64_t column, std::int64_t row) {
  const std::int64_t bit = (column & 7) | ((row & 7) << 3);
  blocks[key_of(column >> 3, row >> 3)] |= std::uint64_t{1} << bit;
}

/// The same cover in cells of twice the side.
Blocks halved(const Blocks& blocks) {
  Blocks coarse;
  for (const auto& [key, bits] : blocks) {
    for (std::uint64_t left = bits; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      set(coarse, (x_of(key) * 8 + (bit & 7)) >> 1, (y_of(key) * 8 + (bit >> 3)) >> 1);
    }
  }
  return coarse;
}

std::uint64_t cell_count(const Blocks& blocks) {
  std::uint64_t count = 0;
  for (const auto& [key, bits] : blocks) count += static_cast<std::uint64_t>(std::popcount(bits));
  return count;
}

}  // namespace

void Occupancy::add(double x, double y) {
  const double columns = std::floor(x / cell_);
  const double rows = std::floor(y / cell_);
  constexpr double kFarthest = 1e10;
  if (!(std::abs(columns) < kFarthest && std::abs(rows) < kFarthest)) return;
  ++points_;
  const auto column = static_cast<std::int64_t>(columns);
  const auto row = static_cast<std::int64_t>(rows);
  const std::uint64_t key = key_of(column >> 3, row >> 3);
  if (latest_ == nullptr || key != latest_key_) {
    if (blocks_.size() >= kMostBlocks && blocks_.find(key) == blocks_.end()) {
      coarsen();
      set(blocks_, column >> 1, row >> 1);
      return;
    }
    latest_ = &blocks_[key];
    latest_key_ = key;
  }
  *latest_ |= std::uint64_t{1} << ((column & 7) | ((row & 7) << 3));
}

void Occupancy::coarsen() {
  blocks_ = halved(blocks_);
  cell_ *= 2.0;
  latest_ = nullptr;
}

Occupancy::Cover Occupancy::cover(double points_per_cell) const {
  Blocks blocks = blocks_;
  Cover cover{cell_, cell_count(blocks)};
  while (cover.cells > 1 &&
         static_cast<double>(points_) < points_per_cell * static_cast<double>(cover.cells)) {
    blocks = halved(blocks);
    cover.cell *= 2.0;
    cover.cells = cell_count(blocks);
    if (cover.cell > 1e12) break;  // points around zero never meet in one cell
  }
  return cover;
}

}  // namespace cornice::info
