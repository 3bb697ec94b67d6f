// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/lax_reader.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/io/lax_writer.h"

namespace cornice::test {
namespace {

struct Indexed {
  std::vector<Vec3d> points;
  std::vector<std::uint8_t> bytes;
};

/// Points that wander about a square, so that intervals are longer than one point.
Indexed indexed_points(std::size_t count, double origin) {
  Indexed result;
  LaxIndex index(false);
  double x = origin, y = origin;
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(7, 0, i);
    x += random.uniform(-3.0, 3.0) + 0.01;
    y += random.uniform(-3.0, 3.0);
    result.points.push_back({x, y, 0.0});
    index.add(x, y);
  }
  const std::string text = index.bytes();
  result.bytes.assign(text.begin(), text.end());
  return result;
}

bool covered(const std::vector<PointInterval>& intervals, std::size_t i) {
  for (const PointInterval& interval : intervals) {
    if (i >= interval.first && i <= interval.last) return true;
  }
  return false;
}

TEST(LaxReader, TheIntervalsOfAWindowCoverEveryPointInIt) {
  for (const double origin : {0.0, 2'700'000.0, -5'000.0}) {
    const Indexed indexed = indexed_points(20000, origin);
    for (const double at : {-50.0, 0.0, 37.0, 100.0}) {
      const Box2d window{origin + at, origin + at, origin + at + 40.0, origin + at + 25.0};
      const auto intervals = lax_intervals_in(indexed.bytes, window, indexed.points.size());
      ASSERT_TRUE(intervals);
      for (std::size_t i = 0; i < indexed.points.size(); ++i) {
        const Vec3d p = indexed.points[i];
        EXPECT_TRUE(!window.contains(p.x, p.y) || covered(*intervals, i)) << i;
      }
    }
  }
}

TEST(LaxReader, AWindowFarFromAllPointsHasFewerIntervalsThanTheWhole) {
  const Indexed indexed = indexed_points(20000, 1000.0);
  const auto all = lax_intervals_in(indexed.bytes, {-1e9, -1e9, 1e9, 1e9}, 20000);
  const auto few = lax_intervals_in(indexed.bytes, {1000, 1000, 1010, 1010}, 20000);
  ASSERT_TRUE(all && few);
  EXPECT_LT(few->size(), all->size());
}

TEST(LaxReader, AnIndexOfAnotherNumberOfPointsIsRefused) {
  const Indexed indexed = indexed_points(500, 0.0);
  EXPECT_FALSE(lax_intervals_in(indexed.bytes, {0, 0, 1, 1}, 499));
  EXPECT_FALSE(lax_intervals_in(indexed.bytes, {0, 0, 1, 1}, 501));
}

TEST(LaxReader, DamagedBytesAreRefusedOrHarmless) {
  const Indexed indexed = indexed_points(3000, 0.0);
  for (std::size_t size = 0; size < indexed.bytes.size(); size += 1 + size / 7) {
    EXPECT_FALSE(lax_intervals_in(std::span(indexed.bytes).first(size), {0, 0, 9, 9}, 3000));
  }
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    CounterRandom random(seed, 1, 0);
    std::vector<std::uint8_t> bytes = indexed.bytes;
    bytes[random.bits() % bytes.size()] ^= static_cast<std::uint8_t>(1 + random.bits() % 255);
    const auto intervals = lax_intervals_in(bytes, {0, 0, 9, 9}, 3000);
    if (!intervals) continue;
    for (const PointInterval& interval : *intervals) EXPECT_LT(interval.last, 3000u);
  }
}

}  // namespace
}  // namespace cornice::test
