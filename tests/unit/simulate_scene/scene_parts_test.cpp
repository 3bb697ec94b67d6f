// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "core/base/random.h"
#include "stages/simulate/scene_canopy.h"
#include "stages/simulate/scene_cubes.h"
#include "stages/simulate/scene_erosion.h"
#include "stages/simulate/scene_noise.h"
#include "stages/simulate/scene_spline.h"

namespace cornice::simulate {
namespace {

TEST(CubePatches, GiveEveryCrossedEdgeOnePatchAndNoOther) {
  for (int solid = 0; solid < 256; ++solid) {
    const CubePatches patches = cube_patches(static_cast<std::uint8_t>(solid));
    for (int e = 0; e < 12; ++e) {
      const CubeEdge edge = cube_edge(e);
      const bool crossed = (solid >> edge.from & 1) != (solid >> edge.to & 1);
      EXPECT_EQ(patches.of_edge[e] != 255, crossed) << "cube " << solid << " edge " << e;
      EXPECT_TRUE(!crossed || patches.of_edge[e] < patches.count);
    }
  }
}

TEST(CubePatches, KeepLoneCornersApart) {
  EXPECT_EQ(cube_patches(0b00000001).count, 1);
  EXPECT_EQ(cube_patches(0b10000001).count, 2);  // opposite corners of the cube
  EXPECT_EQ(cube_patches(0b00001001).count, 2);  // opposite corners of a face, apart in the rock
  EXPECT_EQ(cube_patches(0b01101001).count, 4);
  EXPECT_EQ(cube_patches(0b00001111).count, 1);
}

TEST(CubePatches, FlippingAnAmbiguousFaceJoinsWhatItKeptApart) {
  const CubePatches usual = cube_patches(0b00001001);
  ASSERT_EQ(std::popcount(usual.ambiguous_faces), 1);
  EXPECT_EQ(cube_patches(0b00001001, usual.ambiguous_faces).count, 1);
}

TEST(CubePatches, ADoubledFaceCanAlwaysBeUndoneByFlippingIt) {
  int doubled = 0;
  for (int solid = 0; solid < 256; ++solid) {
    const CubePatches& patches = usual_patches(static_cast<std::uint8_t>(solid));
    if (patches.doubled_faces == 0) continue;
    ++doubled;
    EXPECT_EQ(cube_patches(static_cast<std::uint8_t>(solid), patches.doubled_faces).doubled_faces,
              0)
        << "cube " << solid;
  }
  EXPECT_GT(doubled, 0);
}

TEST(PlanField, ASplineOfAPlaneIsThatPlane) {
  PlanField field({10.0, -4.0, 2.0, 12, 9, 0.5});
  for (int j = 0; j < 9; ++j) {
    for (int i = 0; i < 12; ++i) {
      field.at(i, j) = static_cast<float>(3.0 * field.lattice.x(i) - 0.5 * field.lattice.y(j));
    }
  }
  double dx, dy;
  EXPECT_NEAR(field.value(20.3, 3.7, dx, dy), 3.0 * 20.3 - 0.5 * 3.7, 1e-4);
  EXPECT_NEAR(dx, 3.0, 1e-5);
  EXPECT_NEAR(dy, -0.5, 1e-5);
}

TEST(FloorOf, AgreesWithFloor) {
  for (const double v : {-2.0, -1.5, -0.0, 0.0, 0.3, 7.0, 1e9 + 0.5, -1e9 - 0.5}) {
    EXPECT_EQ(floor_of(v), static_cast<std::int64_t>(std::floor(v))) << v;
  }
}

TEST(GradientNoise, IsSmoothBoundedAndDependsOnTheSeed) {
  double most = 0.0;
  for (int n = 0; n < 20000; ++n) {
    CounterRandom random(5, 1, static_cast<std::uint64_t>(n));
    const double x = random.uniform(-50, 50), y = random.uniform(-50, 50);
    const double v = gradient_noise(x, y, 3);
    most = std::max(most, std::abs(v));
    EXPECT_NEAR(v, gradient_noise(x + 1e-6, y, 3), 1e-5);
  }
  EXPECT_LE(most, 1.5);
  EXPECT_GT(most, 0.7);
  EXPECT_NE(gradient_noise(0.4, 0.7, 1), gradient_noise(0.4, 0.7, 2));
}

PlanField cone(int side, double slope) {
  PlanField field({0.0, 0.0, 4.0, side, side, 0.25});
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double r = 4.0 * std::hypot(i - side / 2, j - side / 2);
      field.at(i, j) = static_cast<float>(slope * (2.0 * side - r));
    }
  }
  return field;
}

TEST(Erosion, LowersGroundCutsGulliesAndLeavesTheBorder) {
  PlanField field = cone(101, 0.8);
  const PlanField before = field;
  erode(field, {1.0, 4.0, 36.0, 60.0}, 9);
  double lowered = 0.0, spread_low = 1e9, spread_high = -1e9;
  for (int n = 0; n < 360; ++n) {  // heights around a circle: equal before, not after
    const double x = 200.0 + 90.0 * std::cos(n * 0.01745), y = 200.0 + 90.0 * std::sin(n * 0.01745);
    lowered += (before.value(x, y) - field.value(x, y)) / 360.0;
    spread_low = std::min(spread_low, field.value(x, y));
    spread_high = std::max(spread_high, field.value(x, y));
  }
  EXPECT_GT(lowered, 2.0);
  EXPECT_GT(spread_high - spread_low, 4.0);
}

TEST(Erosion, NoneLeavesTheGroundAsItIs) {
  PlanField field = cone(41, 0.8);
  const std::vector<float> before = field.values;
  erode(field, {0.0, 4.0, 36.0, 60.0}, 9);
  EXPECT_EQ(field.values, before);
}

Canopy two_trees() {
  return Canopy({{{50.0f, 50.0f, 110.0f}, 3.0f, 8.0f}, {{90.0f, 50.0f, 112.0f}, 2.0f, 6.0f}},
                {0, 0, 120, 120}, 0.5);
}

TEST(CanopyPassage, ABeamThroughTheMiddleCrossesTheWholeCrown) {
  const Canopy canopy = two_trees();
  CanopyPassage passage;
  ASSERT_TRUE(canopy.passage({{50, 50, 500}, {0, 0, -1}}, 400.0, passage));
  EXPECT_NEAR(passage.enter_m, 382.0, 1e-9);
  EXPECT_NEAR(passage.exit_m, 398.0, 1e-9);
  EXPECT_NEAR(passage.density, 0.5, 1e-12);
}

TEST(CanopyPassage, GroundBeforeTheCrownHidesIt) {
  const Canopy canopy = two_trees();
  CanopyPassage passage;
  EXPECT_FALSE(canopy.passage({{50, 50, 500}, {0, 0, -1}}, 380.0, passage));
  EXPECT_TRUE(canopy.passage({{50, 50, 500}, {0, 0, -1}}, 390.0, passage));
  EXPECT_EQ(passage.exit_m, 390.0);
}

TEST(CanopyPassage, ABeamBetweenTreesMeetsNone) {
  const Canopy canopy = two_trees();
  CanopyPassage passage;
  EXPECT_FALSE(canopy.passage({{70, 50, 500}, {0, 0, -1}}, 1e4, passage));
}

TEST(CanopyPassage, ALevelBeamReportsTheNearerTreeAlone) {
  const Canopy canopy = two_trees();
  CanopyPassage passage;
  ASSERT_TRUE(canopy.passage({{0, 50, 110}, {1, 0, 0}}, 1e4, passage));
  EXPECT_NEAR(passage.enter_m, 47.0, 1e-9);
  EXPECT_NEAR(passage.exit_m, 53.0, 1e-9);
  ASSERT_TRUE(canopy.passage({{120, 50, 110}, {-1, 0, 0}}, 1e4, passage));
  EXPECT_NEAR(passage.enter_m, 30.0 - std::sqrt(4.0 * (1.0 - 1.0 / 9.0)), 1e-6);
}

TEST(CanopyPassage, AgreesWithEveryTreeTestedOneByOne) {
  std::vector<Tree> trees;
  for (std::uint64_t n = 0; n < 400; ++n) {
    CounterRandom random(3, 2, n);
    trees.push_back(
        {{static_cast<float>(random.uniform(0, 200)), static_cast<float>(random.uniform(0, 200)),
          static_cast<float>(random.uniform(10, 60))},
         static_cast<float>(random.uniform(1, 4)),
         static_cast<float>(random.uniform(3, 9))});
  }
  const Canopy canopy(trees, {0, 0, 200, 200}, 1.0);
  int met = 0;
  for (std::uint64_t n = 0; n < 5000; ++n) {
    CounterRandom random(4, 2, n);
    const Vec3d from{random.uniform(-100, 300), random.uniform(-100, 300), 300.0};
    const Vec3d to{random.uniform(0, 200), random.uniform(0, 200), 0.0};
    const Ray ray{from, normalized(to - from)};
    double first = 1e30;
    for (const Tree& tree : trees) {
      const Vec3d o = ray.origin - tree.middle.cast<double>();
      const double r = static_cast<double>(tree.radius), h = static_cast<double>(tree.half_height);
      const Vec3d p{o.x / r, o.y / r, o.z / h};
      const Vec3d d{ray.direction.x / r, ray.direction.y / r, ray.direction.z / h};
      const double a = dot(d, d), b = dot(p, d), c = dot(p, p) - 1.0;
      if (b * b - a * c > 1e-9) first = std::min(first, (-b - std::sqrt(b * b - a * c)) / a);
    }
    CanopyPassage passage;
    const bool found = canopy.passage(ray, 1e4, passage);
    EXPECT_EQ(found, first < 1e29);
    if (!found) continue;
    ++met;
    EXPECT_NEAR(passage.enter_m, first, 1e-6);
    EXPECT_GT(passage.exit_m, passage.enter_m);
  }
  EXPECT_GT(met, 1000);
}

}  // namespace
}  // namespace cornice::simulate
