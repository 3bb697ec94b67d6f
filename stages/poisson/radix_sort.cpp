// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/radix_sort.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "core/base/parallel.h"

namespace cornice::poisson {
namespace {

constexpr int kDigitBits = 11;  ///< 2048 streams: their ends stay in the second-level cache
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
constexpr std::size_t kChunk = std::size_t{1} << 20;

using Counts = std::array<std::size_t, kDigits>;

void sort_by_digit(const std::vector<std::uint64_t>& from, std::vector<std::uint64_t>& to,
                   int first_bit, std::uint64_t mask, int threads) {
  const auto digit = [&](std::uint64_t word) { return word >> first_bit & mask; };
  std::vector<Counts> places((from.size() + kChunk - 1) / kChunk);
  parallel_for(from.size(), kChunk, threads, [&](std::size_t begin, std::size_t end) {
    Counts& counts = places[begin / kChunk];
    counts.fill(0);
    for (std::size_t i = begin; i < end; ++i) ++counts[digit(from[i])];
  });
  std::size_t place = 0;
  for (std::size_t d = 0; d < kDigits; ++d) {
    for (Counts& counts : places) {
      const std::size_t count = counts[d];
      counts[d] = place;
      place += count;
    }
  }
  parallel_for(from.size(), kChunk, threads, [&](std::size_t begin, std::size_t end) {
    Counts& next = places[begin / kChunk];
    for (std::size_t i = begin; i < end; ++i) to[next[digit(from[i])]++] = from[i];
  });
}

}  // namespace

void radix_sort(std::vector<std::uint64_t>& words, int first_bit, int last_bit, int threads) {
  assert(0 <= first_bit && first_bit <= last_bit && last_bit <= 64 && "bits of a 64-bit word");
  if (first_bit == last_bit || words.empty()) return;
  const int passes = (last_bit - first_bit + kDigitBits - 1) / kDigitBits;
  std::vector<std::uint64_t> other(words.size());
  for (int pass = 0, bit = first_bit; pass < passes; ++pass) {
    // Digits of nearly equal width: fewer streams a pass than 11 bits and a rest.
    const int bits = (last_bit - bit + passes - pass - 1) / (passes - pass);
    sort_by_digit(words, other, bit, (std::uint64_t{1} << bits) - 1, threads);
    words.swap(other);
    bit += bits;
  }
}

}  // namespace cornice::poisson
