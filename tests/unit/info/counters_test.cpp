// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "stages/info/copy_counter.h"
#include "stages/info/line_table.h"
#include "stages/info/occupancy.h"

namespace cornice::info {
namespace {

TEST(CopyCounter, CountsEveryRepetitionExactlyWhereThereIsRoom) {
  CopyCounter counter;
  for (std::uint64_t i = 0; i < 1000; ++i) counter.add(mix64(i));
  for (std::uint64_t i = 0; i < 100; ++i) counter.add(mix64(i));
  for (std::uint64_t i = 0; i < 10; ++i) counter.add(mix64(i));
  const CopyCounter::Count count = counter.count();
  EXPECT_EQ(count.copies, 110u);
  EXPECT_FALSE(count.estimated);
}

TEST(CopyCounter, CountsMillionsOfCopiesOfOneThingExactly) {
  CopyCounter counter;
  for (int i = 0; i < 3'000'000; ++i) counter.add(mix64(5));
  const CopyCounter::Count count = counter.count();
  EXPECT_EQ(count.copies, 2'999'999u);
  EXPECT_FALSE(count.estimated);
}

TEST(CopyCounter, EstimatesBeyondItsRoom) {
  CopyCounter counter;
  const std::uint64_t things = 3 * CopyCounter::kMostKept;
  for (std::uint64_t i = 0; i < things; ++i) {
    counter.add(mix64(i));
    if (i % 10 == 0) counter.add(mix64(i));
  }
  const CopyCounter::Count count = counter.count();
  EXPECT_TRUE(count.estimated);
  EXPECT_NEAR(static_cast<double>(count.copies), static_cast<double>(things) / 10.0,
              static_cast<double>(things) / 1000.0);
}

TEST(Occupancy, FindsTheAreaOfALatticeOfPoints) {
  Occupancy occupancy(0.5);
  for (int i = 0; i < 400; ++i) {
    for (int k = 0; k < 200; ++k) occupancy.add(1000.0 + 0.25 * i, -500.0 + 0.25 * k);
  }
  const Occupancy::Cover cover = occupancy.cover(8.0);
  const double area = static_cast<double>(cover.cells) * cover.cell * cover.cell;
  EXPECT_DOUBLE_EQ(cover.cell, 1.0);
  EXPECT_NEAR(area, 5000.0, 1.0);
}

TEST(Occupancy, LeavesOutGroundWithoutPoints) {
  Occupancy occupancy(0.5);
  for (const double corner : {0.0, 900.0}) {
    for (int i = 0; i < 100; ++i) {
      for (int k = 0; k < 100; ++k) occupancy.add(corner + 0.2 * i, corner + 0.2 * k);
    }
  }
  const Occupancy::Cover cover = occupancy.cover(8.0);
  EXPECT_NEAR(static_cast<double>(cover.cells) * cover.cell * cover.cell, 800.0, 1.0);
}

TEST(Occupancy, TakesCoarserCellsForFewPointsAndEndsForOne) {
  Occupancy sparse(0.5);
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 40; ++k) sparse.add(10.0 * i, 10.0 * k);
  }
  const Occupancy::Cover cover = sparse.cover(8.0);
  EXPECT_GE(cover.cell, 16.0);
  EXPECT_NEAR(1600.0 / (static_cast<double>(cover.cells) * cover.cell * cover.cell), 0.01, 0.003);
  Occupancy across_zero(0.5);
  across_zero.add(-1.0, -1.0);
  across_zero.add(1.0, 1.0);
  EXPECT_GE(across_zero.cover(8.0).cells, 1u);
  EXPECT_EQ(Occupancy(0.5).cover(8.0).cells, 0u);
}

TEST(LineTable, TellsPassesByTheSilenceBetweenThem) {
  LineTable table;
  for (const double start : {1000.0, 1030.0, 90000.0}) {
    for (int i = 0; i < 100; ++i) table.add(7, 0, start + 0.1 * i);
  }
  for (int i = 0; i < 10; ++i) table.add(7, 1, 1000.0 + i);
  table.add(9, 0, std::nullopt);
  const std::vector<LineFacts> lines = table.lines();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].points, 300u);
  // 20 s from 1010 to 1030 are no silence of more than 20 s.
  EXPECT_EQ(lines[0].passes, 2u);
  EXPECT_EQ(lines[1].channel, 1);
  EXPECT_EQ(lines[1].passes, 1u);
  EXPECT_EQ(lines[2].passes, 0u);
  EXPECT_FALSE(lines[2].first_s);
  EXPECT_TRUE(table.complete());
}

TEST(LineTable, CountsStepsBackWithinEachLineOnly) {
  LineTable table;
  for (const double t : {1.0, 2.0, 1.5, 3.0}) {
    table.add(1, 0, t);
    table.add(2, 0, 100.0 - t);
  }
  EXPECT_EQ(table.steps_back(), 1u + 2u);
}

TEST(LineTable, StaysWithinItsMemoryForScatteredTimes) {
  LineTable table;
  for (int i = 0; i < 1'200'000; ++i) table.add(1, 0, 1.0 + 50.0 * i);
  EXPECT_FALSE(table.complete());
  EXPECT_EQ(table.lines()[0].points, 1'200'000u);
}

}  // namespace
}  // namespace cornice::info
