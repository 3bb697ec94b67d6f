// SPDX-License-Identifier: GPL-3.0-or-later
// How many things were seen before, in bounded memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace cornice::info {

/// Counts repeated hashes. Exact up to kMostKept different ones; beyond, a sample by hash value (a
/// thing and its copies are in it together or not at all) and the count is scaled up.
class CopyCounter {
 public:
  static constexpr std::size_t kMostKept = std::size_t{1} << 22;

  /// hash: evenly spread over 64 bits.
  void add(std::uint64_t hash) {
    if (hash > highest_) return;
    fresh_.push_back(hash);
    if (fresh_.size() >= kFresh) collect();
  }
  struct Count {
    std::uint64_t copies = 0;
    bool estimated = false;
  };
  Count count();

 private:
  struct Entry {
    std::uint64_t hash = 0;
    std::uint64_t seen = 0;
  };
  static constexpr std::size_t kFresh = std::size_t{1} << 20;
  /// Moves the fresh hashes into the sorted ones, and thins those where they are too many.
  void collect();

  std::uint64_t highest_ = std::numeric_limits<std::uint64_t>::max();
  double share_ = 1.0;  ///< of all hashes that are at most highest_
  std::vector<std::uint64_t> fresh_;
  std::vector<Entry> sorted_;  ///< by hash, each once
};

}  // namespace cornice::info
