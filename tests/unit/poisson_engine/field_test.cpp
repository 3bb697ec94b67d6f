// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>

namespace cornice {
namespace {

using Closed = std::array<float, kClosedBrickNodes>;
using Function = std::function<double(double x, double y, double z)>;

/// A level whose bricks sample `f`; positions in units of the finest step.
FieldLevel sample(int level, std::vector<BrickKey> bricks, const Function& f) {
  FieldLevel made;
  made.bricks = std::move(bricks);
  const int spacing = 1 << level;
  for (const BrickKey b : made.bricks) {
    for (int i = 0; i < kBrickNodes; ++i) {
      made.values.push_back(
          static_cast<float>(f(spacing * (8 * b.x + i % 8), spacing * (8 * b.y + i / 8 % 8),
                               spacing * (8 * b.z + i / 64))));
    }
  }
  return made;
}

std::vector<BrickKey> box_of_bricks(int first, int last) {
  std::vector<BrickKey> bricks;
  for (int x = first; x <= last; ++x)
    for (int y = first; y <= last; ++y)
      for (int z = first; z <= last; ++z) bricks.push_back({x, y, z});
  return bricks;
}

double plane(double x, double y, double z) { return 0.25 * x - 0.5 * y + z - 5.25; }

TEST(Field, InterpolatesALinearFunctionExactlyThroughSeveralLevels) {
  const Field field({0.5}, {{}, {}, sample(2, box_of_bricks(-1, 1), plane)});
  for (const BrickKey b : {BrickKey{0, 0, 0}, BrickKey{-3, 1, 2}, BrickKey{3, -4, 3}}) {
    Closed closed;
    ASSERT_TRUE(field.closed_brick(0, b, closed));
    for (int i = 0; i < kClosedBrickNodes; ++i) {
      EXPECT_EQ(closed[i], plane(8 * b.x + i % 9, 8 * b.y + i / 9 % 9, 8 * b.z + i / 81));
    }
  }
}

TEST(Field, PrefersTheFinestStoredValueAndTakesFarFacesFromTheirOwners) {
  const auto fine = [](double, double, double) { return 7.0; };
  const Field field(
      {0.5}, {sample(0, {{0, 0, 0}, {1, 0, 0}}, fine), sample(1, box_of_bricks(-1, 1), plane)});
  Closed closed;
  ASSERT_TRUE(field.closed_brick(0, {0, 0, 0}, closed));
  for (int i = 0; i < kClosedBrickNodes; ++i) {
    const int x = i % 9, y = i / 9 % 9, z = i / 81;
    EXPECT_EQ(closed[i], y < 8 && z < 8 ? 7.0 : plane(x, y, z)) << x << ' ' << y << ' ' << z;
  }
}

TEST(Field, GivesOneValueToANodeWhicheverBrickItIsReadWith) {
  const auto rough = [](double x, double y, double z) {
    return std::sin(0.37 * x) + std::cos(0.91 * y) * std::sin(1.3 * z) + 0.1 * x;
  };
  const Field field({0.5}, {sample(0, {{0, 0, 0}, {1, 1, 0}}, plane),
                            sample(1, {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}, rough),
                            sample(2, box_of_bricks(-1, 1), rough)});
  std::map<std::array<int, 3>, float> seen;
  for (const BrickKey b : box_of_bricks(-3, 3)) {
    Closed closed;
    ASSERT_TRUE(field.closed_brick(0, b, closed));
    for (int i = 0; i < kClosedBrickNodes; ++i) {
      const std::array<int, 3> node{8 * b.x + i % 9, 8 * b.y + i / 9 % 9, 8 * b.z + i / 81};
      EXPECT_EQ(seen.try_emplace(node, closed[i]).first->second, closed[i]);
    }
  }
}

TEST(Field, SaysWhereNoLevelCoversABrick) {
  const Field field({0.5}, {{}, sample(1, {{0, 0, 0}}, plane)});
  Closed closed;
  EXPECT_FALSE(field.closed_brick(0, {5, 5, 5}, closed));
  EXPECT_FALSE(field.closed_brick(0, {1, 1, 1}, closed)) << "its far faces are in the next brick";
  EXPECT_FALSE(field.closed_brick(2, {0, 0, 0}, closed));
  EXPECT_FALSE(Field().closed_brick(0, {0, 0, 0}, closed));
  EXPECT_TRUE(Field().crossing_bricks({-9, -9, -9}, {9, 9, 9}, 1).empty());
}

/// What crossing_bricks promises, brick by brick.
std::vector<BrickKey> crossing_by_force(const Field& field, int first, int last) {
  std::vector<BrickKey> crossing;
  for (const BrickKey b : box_of_bricks(first, last)) {
    Closed closed;
    if (!field.closed_brick(0, b, closed)) continue;
    const auto [low, high] = std::minmax_element(closed.begin(), closed.end());
    if (*low <= 0 && *high >= 0 && (*low != 0 || *high != 0)) crossing.push_back(b);
  }
  return crossing;
}

TEST(Field, FindsTheSameCrossingBricksAsLookingAtEachOne) {
  const auto hill = [](double x, double y, double z) {
    return z - 9.0 - 12.0 * std::sin(0.05 * x) * std::cos(0.07 * y);
  };
  // The finer levels lie apart from the coarser ones' zero, so that faces between levels cross too.
  const auto lifted = [&](double x, double y, double z) { return hill(x, y, z) - 6.0; };
  const Field field({0.5}, {sample(0, {{-2, 0, 0}, {0, 1, 1}, {1, 1, 1}, {2, 3, -1}}, lifted),
                            sample(1, {{-1, -1, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 1}}, lifted),
                            sample(2, box_of_bricks(-1, 1), hill)});
  const std::vector<BrickKey> expected = crossing_by_force(field, -4, 4);
  EXPECT_GT(expected.size(), 20u);
  EXPECT_EQ(field.crossing_bricks({-4, -4, -4}, {4, 4, 4}, 1), expected);
  EXPECT_EQ(field.crossing_bricks({-4, -4, -4}, {4, 4, 4}, 2), expected);
  EXPECT_EQ(field.crossing_bricks({-1, -1, -1}, {2, 2, 2}, 1), crossing_by_force(field, -1, 2));
}

TEST(Field, CrossesNowhereWhereItIsZeroThroughout) {
  const auto zero = [](double, double, double) { return 0.0; };
  const Field field({0.5}, {sample(0, box_of_bricks(-1, 1), zero)});
  EXPECT_TRUE(field.crossing_bricks({-1, -1, -1}, {1, 1, 1}, 1).empty());
}

}  // namespace
}  // namespace cornice
