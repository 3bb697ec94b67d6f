// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/range_allocator.h"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace cornice::viewer {

RangeAllocator::RangeAllocator(std::uint64_t size) : none_from_(size + 1) {
  if (size > 0) free_.emplace(0, size);
}

std::optional<std::uint64_t> RangeAllocator::take(std::uint64_t count) {
  if (count == 0) return 0;
  if (count >= none_from_) return std::nullopt;
  for (auto range = free_.begin(); range != free_.end(); ++range) {
    const auto [first, free_count] = *range;
    if (free_count < count) continue;
    free_.erase(range);
    if (free_count > count) free_[first + count] = free_count - count;
    used_ += count;
    return first;
  }
  none_from_ = count;
  return std::nullopt;
}

void RangeAllocator::give_back(std::uint64_t first, std::uint64_t count) {
  if (count == 0) return;
  assert(used_ >= count);
  used_ -= count;
  add_free(first, count);
}

void RangeAllocator::add_free(std::uint64_t first, std::uint64_t count) {
  auto range = free_.emplace(first, count).first;
  if (const auto next = std::next(range); next != free_.end() && first + count == next->first) {
    range->second += next->second;
    free_.erase(next);
  }
  if (range != free_.begin()) {
    if (const auto before = std::prev(range); before->first + before->second == first) {
      before->second += range->second;
      free_.erase(range);
      range = before;
    }
  }
  none_from_ = std::max(none_from_, range->second + 1);
}

}  // namespace cornice::viewer
