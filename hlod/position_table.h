// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the vertex at a lattice point: open addressing, no memory but one number per slot.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hlod/lattice.h"

namespace cornice::hlod {

inline std::size_t hash_position(LatticePoint p) {
  const auto word = [](std::int32_t i) { return std::uint64_t{static_cast<std::uint32_t>(i)}; };
  std::uint64_t h = (word(p.x) | word(p.y) << 32) * 0x9e3779b97f4a7c15u;
  h = (h ^ h >> 32 ^ word(p.z)) * 0xd6e8feb86659fd93u;
  return static_cast<std::size_t>(h ^ h >> 32);
}

/// Tells most points that are alone without a look at others, in two bytes for each that is
/// expected. Keeps its memory from use to use.
class PositionFilter {
 public:
  void reset(std::size_t expected) { words_.assign(std::bit_ceil(expected / 4 + 1), {}); }
  void add(LatticePoint p) {
    const std::size_t h = hash_position(p);
    Word& word = words_[h >> 6 & (words_.size() - 1)];
    const std::uint64_t bit = std::uint64_t{1} << (h & 63);
    word.twice |= word.once & bit;
    word.once |= bit;
  }
  /// False for every point that was added twice, and for a few others.
  bool is_alone(LatticePoint p) const {
    const std::size_t h = hash_position(p);
    return (words_[h >> 6 & (words_.size() - 1)].twice >> (h & 63) & 1) == 0;
  }

 private:
  struct Word {
    std::uint64_t once = 0, twice = 0;
  };
  std::vector<Word> words_;
};

/// Indices of points that its owner keeps. Keeps its memory from use to use.
class PositionTable {
 public:
  /// Empties it and makes room for `expected` points; more are taken, too.
  void reset(std::size_t expected) {
    slots_.assign(std::bit_ceil(2 * expected + 16), kEmpty);
    used_ = 0;
  }

  /// Index of the point at p among those added before; adds `index` and returns it where there is
  /// none. position_of(i) is the point that index i stands for.
  template <class PositionOf>
  std::uint32_t find_or_add(LatticePoint p, std::uint32_t index, const PositionOf& position_of) {
    if (2 * used_ >= slots_.size()) grow(position_of);
    const std::size_t place = locate(p, position_of);
    if (slots_[place] != kEmpty) return slots_[place];
    ++used_;
    return slots_[place] = index;
  }
  /// Index of the point at p, or kEmpty.
  template <class PositionOf>
  std::uint32_t find(LatticePoint p, const PositionOf& position_of) const {
    return slots_[locate(p, position_of)];
  }

  static constexpr std::uint32_t kEmpty = 0xffffffffu;

 private:
  template <class PositionOf>
  std::size_t locate(LatticePoint p, const PositionOf& position_of) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t place = hash_position(p) & mask;
    while (slots_[place] != kEmpty && !(position_of(slots_[place]) == p)) {
      place = (place + 1) & mask;
    }
    return place;
  }
  template <class PositionOf>
  void grow(const PositionOf& position_of) {
    std::vector<std::uint32_t> old(2 * slots_.size(), kEmpty);
    old.swap(slots_);
    for (const std::uint32_t index : old) {
      if (index != kEmpty) slots_[locate(position_of(index), position_of)] = index;
    }
  }

  std::vector<std::uint32_t> slots_;
  std::size_t used_ = 0;
};

}  // namespace cornice::hlod
