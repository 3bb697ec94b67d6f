// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/bricks.h"

#include <gtest/gtest.h>

namespace cornice {
namespace {

TEST(BrickIndex, FindsEveryKeyAtItsPositionAndNoOther) {
  std::vector<BrickKey> bricks;
  for (int i = 0; i < 5000; ++i) bricks.push_back({i % 17 - 8, i % 19 - 9, i / 323 - 7});
  const BrickIndex index(bricks);
  for (std::uint32_t i = 0; i < bricks.size(); ++i) EXPECT_EQ(index.find(bricks, bricks[i]), i);
  EXPECT_EQ(index.find(bricks, {9, 0, 0}), BrickIndex::kNone);
  EXPECT_EQ(index.find(bricks, {0, 0, 100}), BrickIndex::kNone);
}

TEST(BrickIndex, OfNothingFindsNothing) {
  EXPECT_EQ(BrickIndex().find({}, {0, 0, 0}), BrickIndex::kNone);
  EXPECT_EQ(BrickIndex(std::span<const BrickKey>()).find({}, {0, 0, 0}), BrickIndex::kNone);
}

TEST(BrickIndex, TellsKeysApartWhoseCoordinatesAreSwappedOrNegated) {
  const std::vector<BrickKey> bricks{{1, 2, 3}, {3, 2, 1}, {-1, 2, 3}, {1, -2, 3}, {2, 1, 3}};
  const BrickIndex index(bricks);
  for (std::uint32_t i = 0; i < bricks.size(); ++i) EXPECT_EQ(index.find(bricks, bricks[i]), i);
}

TEST(BrickKey, HasItsParentBelowOnBothSidesOfZero) {
  EXPECT_EQ(parent({5, 4, 1}), (BrickKey{2, 2, 0}));
  EXPECT_EQ(parent({-1, -2, -3}), (BrickKey{-1, -1, -2}));
}

}  // namespace
}  // namespace cornice
