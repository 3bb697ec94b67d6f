// SPDX-License-Identifier: GPL-3.0-or-later
// Sorting by some bits of an unsigned key, least significant digit first, in parallel.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/parallel.h"

namespace cornice {
namespace detail {

inline constexpr int kRadixBits = 11;  ///< 2048 streams: their ends stay in the second-level cache
inline constexpr std::size_t kRadixChunk = std::size_t{1} << 20;

/// One pass. Returns false, `to` untouched, where all items have the same digit.
template <class Item, class Key>
bool sort_by_digit(const std::vector<Item>& from, std::vector<Item>& to, int first_bit,
                   std::uint64_t mask, int threads, const Key& key) {
  using Counts = std::array<std::size_t, std::size_t{1} << kRadixBits>;
  const auto digit = [&](const Item& item) { return key(item) >> first_bit & mask; };
  std::vector<Counts> places((from.size() + kRadixChunk - 1) / kRadixChunk);
  parallel_for(from.size(), kRadixChunk, threads, [&](std::size_t begin, std::size_t end) {
    Counts& counts = places[begin / kRadixChunk];
    counts.fill(0);
    for (std::size_t i = begin; i < end; ++i) ++counts[digit(from[i])];
  });
  std::size_t place = 0;
  for (std::uint64_t d = 0; d <= mask; ++d) {
    const std::size_t before = place;
    for (Counts& counts : places) {
      const std::size_t count = counts[d];
      counts[d] = place;
      place += count;
    }
    if (place - before == from.size()) return false;
  }
  parallel_for(from.size(), kRadixChunk, threads, [&](std::size_t begin, std::size_t end) {
    Counts& next = places[begin / kRadixChunk];
    for (std::size_t i = begin; i < end; ++i) to[next[digit(from[i])]++] = from[i];
  });
  return true;
}

}  // namespace detail

/// Sorts `items` by bits [first_bit, last_bit), 0 <= first_bit <= last_bit <= 64, of the
/// std::uint64_t that key(item) returns; items that agree in them keep their order. Needs as much
/// memory again. The same for any number of threads (0: all cores).
template <class Item, class Key>
void radix_sort(std::vector<Item>& items, int first_bit, int last_bit, int threads,
                const Key& key) {
  assert(0 <= first_bit && first_bit <= last_bit && last_bit <= 64 && "bits of a 64-bit key");
  if (first_bit == last_bit || items.empty()) return;
  const int passes = (last_bit - first_bit + detail::kRadixBits - 1) / detail::kRadixBits;
  std::vector<Item> other(items.size());
  for (int pass = 0, bit = first_bit; pass < passes; ++pass) {
    // Digits of nearly equal width: fewer streams a pass than 11 bits and a rest.
    const int bits = (last_bit - bit + passes - pass - 1) / (passes - pass);
    const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
    if (detail::sort_by_digit(items, other, bit, mask, threads, key)) items.swap(other);
    bit += bits;
  }
}

}  // namespace cornice
