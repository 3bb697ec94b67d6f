// SPDX-License-Identifier: GPL-3.0-or-later
// Which parts of a buffer are free.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace cornice::viewer {

/// Hands out ranges of [0, size): the lowest that is large enough, so the same requests get the
/// same places. Neighbouring free ranges are joined. What is refused costs no search the next time.
class RangeAllocator {
 public:
  explicit RangeAllocator(std::uint64_t size);
  /// First item of the range; nothing where no free range is that long.
  std::optional<std::uint64_t> take(std::uint64_t count);
  /// Gives back what take(count) gave.
  void give_back(std::uint64_t first, std::uint64_t count);
  std::uint64_t used() const { return used_; }

 private:
  void add_free(std::uint64_t first, std::uint64_t count);

  std::map<std::uint64_t, std::uint64_t> free_;  ///< first item, count
  std::uint64_t used_ = 0;
  std::uint64_t none_from_;  ///< no free range is known to be so long
};

}  // namespace cornice::viewer
