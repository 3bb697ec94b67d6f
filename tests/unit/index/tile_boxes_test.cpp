// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/index/tile_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"

namespace cornice::index {
namespace {

constexpr double kStep = 0.5;
constexpr double kSeam = 2.0;

TileBoxes boxes_of(const std::vector<Box2d>& bounds) {
  std::vector<Footprint> footprints;
  for (const Box2d& b : bounds) footprints.push_back({b, std::nullopt});
  return lay_out(footprints, kStep, kSeam);
}

double overlap(const Box2d& a, const Box2d& b) {
  const double x = std::min(a.max_x, b.max_x) - std::max(a.min_x, b.min_x);
  const double y = std::min(a.max_y, b.max_y) - std::max(a.min_y, b.min_y);
  return x > 0.0 && y > 0.0 ? x * y : 0.0;
}

TEST(TileBoxes, AreTheNamesOwnWhereTheNamesSayThem) {
  const Box2d name{2746000, 1234000, 2747000, 1235000};
  const TileBoxes result = lay_out({{{2746300, 1234010, 2746990, 1234800}, name}}, kStep, kSeam);
  EXPECT_EQ(result.boxes.at(0), name);
}

TEST(TileBoxes, AreCellsOfTheGridThatTheTilesWereCutFrom) {
  // The western tile's points end 8 m before its border: water.
  const TileBoxes result = boxes_of({{770500, 6277500, 770541.7, 6277550},
                                     {770550, 6277500.01, 770599.99, 6277550},
                                     {770550, 6277550, 770600, 6277599.98}});
  EXPECT_EQ(result.boxes.at(0), (Box2d{770500, 6277500, 770550, 6277550}));
  EXPECT_EQ(result.boxes.at(1), (Box2d{770550, 6277500, 770600, 6277550}));
  EXPECT_EQ(result.boxes.at(2), (Box2d{770550, 6277550, 770600, 6277600}));
}

TEST(TileBoxes, AreTheBoundsOnTheLatticeWhereThereIsNoGrid) {
  const TileBoxes result = boxes_of({{885022.4, 629157.2, 885210.2, 629400.0}});
  EXPECT_EQ(result.boxes.at(0), (Box2d{885022.0, 629157.0, 885210.5, 629400.0}));
}

TEST(TileBoxes, DoNotGrowByAStepForARoundedCoordinate) {
  const TileBoxes result = boxes_of({{99.995, 0.0, 347.0, 211.004}});
  EXPECT_EQ(result.boxes.at(0), (Box2d{100.0, 0.0, 347.0, 211.0}));
}

TEST(TileBoxes, MeetInTheMiddleOfASmallGap) {
  const TileBoxes result = boxes_of({{0, 0, 299.0, 341}, {300.5, 0, 613, 341}});
  EXPECT_EQ(result.boxes.at(0).max_x, result.boxes.at(1).min_x);
  EXPECT_NEAR(result.boxes.at(0).max_x, 299.75, 0.5);
}

TEST(TileBoxes, KeepAWideGap) {
  const TileBoxes result = boxes_of({{0, 0, 299, 341}, {310, 0, 613, 341}});
  EXPECT_EQ(result.boxes.at(0).max_x, 299.0);
  EXPECT_EQ(result.boxes.at(1).min_x, 310.0);
}

TEST(TileBoxes, CutAnOverlapInItsMiddle) {
  const TileBoxes result = boxes_of({{0, 0, 320, 341}, {280, 0, 613, 341}});
  EXPECT_EQ(result.boxes.at(0).max_x, 300.0);
  EXPECT_EQ(result.boxes.at(1).min_x, 300.0);
  EXPECT_EQ(result.boxes.at(0).max_y, 341.0);
}

TEST(TileBoxes, NameTheTileThatCoversTheSameGround) {
  const TileBoxes result = boxes_of({{0, 0, 313, 341}, {1, 2, 311, 340}, {313, 0, 590, 341}});
  EXPECT_EQ(result.inside.at(0), kNobody);
  EXPECT_EQ(result.inside.at(1), 0u);
  EXPECT_EQ(result.inside.at(2), kNobody);
}

TEST(TileBoxes, LeaveATileWholeThatHoldsTheFewPointsOfAnother) {
  const Box2d large{0, 0, 313, 341}, other{313, 0, 590, 341};
  const std::vector<Box2d> few{{300, 20, 305, 22}, {0, 0, 3, 2}, {150, 170, 150, 170}};
  for (const Box2d& points : few) {
    for (const bool comes_first : {true, false}) {
      const auto result =
          comes_first ? boxes_of({points, large, other}) : boxes_of({large, other, points});
      const std::size_t at = comes_first ? 0 : 2, around = comes_first ? 1 : 0;
      EXPECT_EQ(result.inside.at(at), around);
      EXPECT_EQ(result.inside.at(around), kNobody);
      EXPECT_EQ(result.boxes.at(around), large);
      EXPECT_EQ(result.boxes.at(around + 1), other);
    }
  }
}

TEST(TileBoxes, KeepATileOfFewPointsBesideOthers) {
  const TileBoxes result = boxes_of({{0, 0, 313, 341}, {320, 5, 322, 6}});
  EXPECT_EQ(result.inside.at(1), kNobody);
  EXPECT_EQ(result.boxes.at(1), (Box2d{320, 5, 322, 6}));
}

TEST(TileBoxes, NeverOverlapWhateverTheBoundsOfARegularSurvey) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    std::vector<Box2d> bounds;
    CounterRandom random(seed, 1, 0);
    const auto jitter = [&] { return random.uniform(-0.9, 0.9); };
    for (int i = 0; i < 9; ++i) {
      const double x = 311.0 * (i % 3), y = 287.0 * (i / 3);
      bounds.push_back({x + jitter(), y + jitter(), x + 311 + jitter(), y + 287 + jitter()});
    }
    const TileBoxes result = boxes_of(bounds);
    for (std::size_t i = 0; i < 9; ++i) {
      const Box2d& box = result.boxes[i];
      for (const double edge : {box.min_x, box.min_y, box.max_x, box.max_y})
        EXPECT_EQ(edge, std::round(edge / kStep) * kStep);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_EQ(overlap(box, result.boxes[j]), 0.0) << seed << " " << i << " " << j;
      // Beside each other: one border.
      if (i % 3 != 2) {
        EXPECT_EQ(box.max_x, result.boxes[i + 1].min_x) << seed << " " << i;
      }
      if (i < 6) {
        EXPECT_EQ(box.max_y, result.boxes[i + 3].min_y) << seed << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace cornice::index
