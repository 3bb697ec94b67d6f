// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/range_allocator.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.h"

namespace cornice::viewer {
namespace {

TEST(RangeAllocator, NeverHandsOutAPlaceTwiceAndForgetsNone) {
  constexpr std::uint64_t kSize = 1000;
  RangeAllocator ranges(kSize);
  CounterRandom random(3, 1, 4);
  std::vector<std::uint8_t> taken(kSize, 0);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> held;
  std::uint64_t used = 0;
  for (int step = 0; step < 20000; ++step) {
    if (held.empty() || random.uniform() < 0.55) {
      const auto count = static_cast<std::uint64_t>(random.uniform(1.0, 90.0));
      const auto first = ranges.take(count);
      if (!first) continue;
      ASSERT_LE(*first + count, kSize);
      for (std::uint64_t i = *first; i < *first + count; ++i) {
        ASSERT_EQ(taken[i], 0);
        taken[i] = 1;
      }
      held.push_back({*first, count});
      used += count;
    } else {
      const auto which = static_cast<std::size_t>(random.uniform() * double(held.size()));
      const auto [first, count] = held[which];
      held[which] = held.back();
      held.pop_back();
      for (std::uint64_t i = first; i < first + count; ++i) taken[i] = 0;
      ranges.give_back(first, count);
      used -= count;
    }
    ASSERT_EQ(ranges.used(), used);
  }
  for (const auto& [first, count] : held) ranges.give_back(first, count);
  EXPECT_EQ(ranges.take(kSize), 0u) << "what was given back is one range again";
}

TEST(RangeAllocator, SaysWhenThereIsNoRoom) {
  RangeAllocator ranges(10);
  EXPECT_EQ(ranges.take(6), 0u);
  EXPECT_EQ(ranges.take(5), std::nullopt);
  EXPECT_EQ(ranges.take(4), 6u);
  EXPECT_EQ(RangeAllocator(0).take(1), std::nullopt);
}

TEST(RangeAllocator, GivesWhatItRefusedOnceThereIsRoomForIt) {
  RangeAllocator ranges(10);
  ASSERT_EQ(ranges.take(4), 0u);
  ASSERT_EQ(ranges.take(2), 4u);
  ASSERT_FALSE(ranges.take(5));
  ASSERT_FALSE(ranges.take(6));
  ranges.give_back(4, 2);
  EXPECT_EQ(ranges.take(6), 4u);
  ranges.give_back(0, 4);
  EXPECT_FALSE(ranges.take(5));
  EXPECT_EQ(ranges.take(4), 0u);
}

TEST(RangeAllocator, HasRoomForNothingWhereItIsFull) {
  RangeAllocator ranges(4);
  ASSERT_TRUE(ranges.take(4));
  EXPECT_TRUE(ranges.take(0));
  EXPECT_EQ(ranges.used(), 4u);
}

}  // namespace
}  // namespace cornice::viewer
