// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/range_allocator.h"

#include <cassert>
#include <iterator>

namespace cornice::viewer {

RangeAllocator::RangeAllocator(std::uint64_t size) { extend(size); }

std::optional<std::uint64_t> RangeAllocator::take(std::uint64_t count) {
  if (count == 0) return 0;
  for (auto range = free_.begin(); range != free_.end(); ++range) {
    const auto [first, free_count] = *range;
    if (free_count < count) continue;
    free_.erase(range);
    if (free_count > count) free_[first + count] = free_count - count;
    used_ += count;
    return first;
  }
  return std::nullopt;
}

void RangeAllocator::give_back(std::uint64_t first, std::uint64_t count) {
  if (count == 0) return;
  assert(used_ >= count);
  used_ -= count;
  add_free(first, count);
}

void RangeAllocator::extend(std::uint64_t count) {
  if (count > 0) add_free(size_, count);
  size_ += count;
}

void RangeAllocator::add_free(std::uint64_t first, std::uint64_t count) {
  auto range = free_.emplace(first, count).first;
  if (const auto next = std::next(range); next != free_.end() && first + count == next->first) {
    range->second += next->second;
    free_.erase(next);
  }
  if (range == free_.begin()) return;
  if (const auto before = std::prev(range); before->first + before->second == first) {
    before->second += range->second;
    free_.erase(range);
  }
}

}  // namespace cornice::viewer
