// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/morton_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/parallel.h"

namespace cornice::normals {
namespace {

constexpr std::size_t kGrain = 1u << 18;
constexpr int kBitsPerAxis = 21;
constexpr int kDigitBits = 11;
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
constexpr int kTopDigitBits = 13;
constexpr std::size_t kTopDigits = std::size_t{1} << kTopDigitBits;
/// Points that are sorted by comparing.
constexpr std::size_t kSmallPart = 1024;

/// Spreads the low 21 bits of v to every third bit.
constexpr std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  v = (v | v << 2) & 0x1249249249249249ULL;
  return v;
}

struct Cube {
  Vec3f min;
  float side = 0.0f;
};

Cube bounding_cube(std::span<const Vec3f> positions, int threads) {
  struct Bounds {
    Vec3f low{std::numeric_limits<float>::max(), std::numeric_limits<float>::max(),
              std::numeric_limits<float>::max()};
    Vec3f high{std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
               std::numeric_limits<float>::lowest()};
    void add(Vec3f a, Vec3f b) {
      low = {std::min(low.x, a.x), std::min(low.y, a.y), std::min(low.z, a.z)};
      high = {std::max(high.x, b.x), std::max(high.y, b.y), std::max(high.z, b.z)};
    }
  };
  const Bounds all = parallel_reduce(
      positions.size(), kGrain, threads, Bounds{},
      [&](std::size_t begin, std::size_t end) {
        Bounds part;
        for (std::size_t i = begin; i < end; ++i) part.add(positions[i], positions[i]);
        return part;
      },
      [](Bounds& sum, const Bounds& part) { sum.add(part.low, part.high); });
  const Vec3f size = all.high - all.low;
  return {all.low, std::max({size.x, size.y, size.z})};
}

/// Sorts by `digit` bits of the keys from `shift`, stably; begins[d] is where digit d starts in
/// `to`. Chunks are fixed by size, so every chunk knows its places from the chunks before it,
/// whatever thread runs it.
std::vector<std::uint32_t> scatter_by_top_digit(const MortonOrder& from, MortonOrder& to, int shift,
                                                int threads) {
  const std::size_t n = from.keys.size();
  const std::size_t chunks = (n + kGrain - 1) / kGrain;
  std::vector<std::array<std::uint32_t, kTopDigits>> places(chunks);
  const auto digit = [shift](std::uint64_t key) {
    return static_cast<std::size_t>(key >> shift) & (kTopDigits - 1);
  };
  parallel_for(n, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    auto& counts = places[begin / kGrain];
    counts.fill(0);
    for (std::size_t i = begin; i < end; ++i) ++counts[digit(from.keys[i])];
  });
  std::vector<std::uint32_t> begins;
  std::uint32_t next = 0;
  for (std::size_t d = 0; d < kTopDigits; ++d) {
    begins.push_back(next);
    for (std::size_t c = 0; c < chunks; ++c) next += std::exchange(places[c][d], next);
  }
  begins.push_back(next);
  parallel_for(n, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    auto& place = places[begin / kGrain];
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t rank = place[digit(from.keys[i])]++;
      to.keys[rank] = from.keys[i];
      to.order[rank] = from.order[i];
    }
  });
  return begins;
}

/// A part of a MortonOrder.
struct Part {
  std::uint64_t* keys;
  std::uint32_t* order;
};

/// Sorts `count` entries by the `bits` lowest bits of their keys, stably: a radix sort, least
/// significant digit first, between the part and `scratch`.
void sort_part(Part part, Part scratch, std::size_t count, int bits) {
  std::array<std::uint32_t, kDigits> places;
  int passes = 0;
  for (int shift = 0; shift < bits; shift += kDigitBits, ++passes) {
    const auto digit = [shift](std::uint64_t key) {
      return static_cast<std::size_t>(key >> shift) & (kDigits - 1);
    };
    places.fill(0);
    for (std::size_t i = 0; i < count; ++i) ++places[digit(part.keys[i])];
    std::uint32_t next = 0;
    for (std::uint32_t& place : places) next += std::exchange(place, next);
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t rank = places[digit(part.keys[i])]++;
      scratch.keys[rank] = part.keys[i];
      scratch.order[rank] = part.order[i];
    }
    std::swap(part, scratch);
  }
  if (passes % 2 == 0) return;
  std::copy_n(part.keys, count, scratch.keys);
  std::copy_n(part.order, count, scratch.order);
}

/// The same for a few entries: a histogram would take longer than they do.
void sort_small_part(Part part, std::size_t count) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> entries(count);
  for (std::size_t i = 0; i < count; ++i) entries[i] = {part.keys[i], part.order[i]};
  std::sort(entries.begin(), entries.end());
  for (std::size_t i = 0; i < count; ++i) std::tie(part.keys[i], part.order[i]) = entries[i];
}

/// Equal keys mean points within a two-millionth of the cube's side of each other, mostly copies.
void sort_equal_keys(Part part, std::size_t count, std::span<const Vec3f> positions) {
  const auto lexicographic = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3f p = positions[a], q = positions[b];
    return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
  };
  for (std::size_t begin = 0; begin < count;) {
    std::size_t end = begin + 1;
    while (end < count && part.keys[end] == part.keys[begin]) ++end;
    if (end - begin > 1) std::sort(part.order + begin, part.order + end, lexicographic);
    begin = end;
  }
}

/// Lowest bit of the digit that holds the highest bit in which keys differ.
int top_shift(const std::vector<std::uint64_t>& keys, int threads) {
  const std::uint64_t differing = parallel_reduce(
      keys.size(), kGrain, threads, std::uint64_t{0},
      [&](std::size_t begin, std::size_t end) {
        std::uint64_t bits = 0;
        for (std::size_t i = begin; i < end; ++i) bits |= keys[i] ^ keys.front();
        return bits;
      },
      [](std::uint64_t& sum, std::uint64_t part) { sum |= part; });
  return std::max(static_cast<int>(std::bit_width(differing)) - kTopDigitBits, 0);
}

}  // namespace

std::vector<std::uint64_t> morton_keys(std::span<const Vec3f> positions, int threads) {
  std::vector<std::uint64_t> keys(positions.size());
  if (positions.empty()) return keys;
  const Cube cube = bounding_cube(positions, threads);
  constexpr double kSteps = static_cast<double>((1u << kBitsPerAxis) - 1);
  const double scale = cube.side > 0.0f ? kSteps / static_cast<double>(cube.side) : 0.0;
  const auto quantised = [scale](float value, float low) {
    return static_cast<std::uint64_t>((static_cast<double>(value) - static_cast<double>(low)) *
                                      scale);
  };
  parallel_for(positions.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f p = positions[i];
      keys[i] = spread(quantised(p.x, cube.min.x)) | spread(quantised(p.y, cube.min.y)) << 1 |
                spread(quantised(p.z, cube.min.z)) << 2;
    }
  });
  return keys;
}

MortonOrder sort_along_curve(std::span<const Vec3f> positions, int threads) {
  assert(positions.size() < std::numeric_limits<std::uint32_t>::max());
  MortonOrder sorted;
  sorted.keys = morton_keys(positions, threads);
  sorted.order.resize(positions.size());
  std::iota(sorted.order.begin(), sorted.order.end(), 0u);
  if (positions.empty()) return sorted;
  MortonOrder other;
  other.keys.resize(positions.size());
  other.order.resize(positions.size());
  // The first digit parts the points into squares of ground that fit a core's cache.
  const int shift = top_shift(sorted.keys, threads);
  const std::vector<std::uint32_t> begins = scatter_by_top_digit(sorted, other, shift, threads);
  parallel_for(kTopDigits, 1, threads, [&](std::size_t d, std::size_t) {
    const std::size_t begin = begins[d], count = begins[d + 1] - begin;
    const Part part{other.keys.data() + begin, other.order.data() + begin};
    if (count <= kSmallPart) {
      sort_small_part(part, count);
    } else {
      sort_part(part, {sorted.keys.data() + begin, sorted.order.data() + begin}, count, shift);
    }
    sort_equal_keys(part, count, positions);
  });
  std::swap(sorted, other);
  return sorted;
}

}  // namespace cornice::normals
