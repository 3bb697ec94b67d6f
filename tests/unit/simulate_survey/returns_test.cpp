// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/returns.h"

#include <gtest/gtest.h>

#include <cmath>

#include "property/simulate_survey/test_scenes.h"

namespace cornice::simulate {
namespace {

test::PlaneScene plane() {
  test::PlaneScene scene;
  scene.extent = {0.0, 0.0, 100.0, 100.0};
  return scene;
}
const Ray kDown{{50.0, 50.0, 1700.0}, {0.0, 0.0, -1.0}};

TEST(Returns, BareGroundGivesOneEchoWhereTheBeamMeetsIt) {
  CounterRandom random(1, 2, 3);
  const EchoList echoes = follow_pulse(plane(), kDown, 5, random);
  ASSERT_EQ(echoes.count, 1);
  EXPECT_NEAR(echoes.echoes[0].range_m, 1200.0, 1e-9);
  EXPECT_EQ(echoes.echoes[0].surface, SurfaceId::kGround);
  EXPECT_EQ(echoes.echoes[0].energy, 1.0);
}

TEST(Returns, LeavesGiveEchoesInOrderOfRangeApartAndAboveTheGround) {
  test::PlaneScene scene = plane();
  scene.canopy_west = 0.0;
  scene.canopy_east = 100.0;
  int several = 0, grounds = 0;
  for (std::uint64_t pulse = 0; pulse < 2000; ++pulse) {
    CounterRandom random(1, 2, pulse);
    const EchoList echoes = follow_pulse(scene, kDown, 5, random);
    ASSERT_LE(echoes.count, 5);
    several += echoes.count > 1 ? 1 : 0;
    for (int i = 0; i < echoes.count; ++i) {
      const Echo& echo = echoes.echoes[static_cast<std::size_t>(i)];
      if (echo.surface == SurfaceId::kGround) {
        EXPECT_EQ(i, echoes.count - 1);
        ++grounds;
        continue;
      }
      EXPECT_EQ(echo.surface, SurfaceId::kVegetation);
      EXPECT_GE(echo.above_ground_m, 3.0);
      EXPECT_LE(echo.above_ground_m, 15.0);
      EXPECT_NEAR(norm(echo.normal), 1.0, 1e-12);
      if (i > 0) {
        EXPECT_GE(echo.range_m - echoes.echoes[static_cast<std::size_t>(i - 1)].range_m, 0.59);
        EXPECT_LT(echo.energy, echoes.echoes[static_cast<std::size_t>(i - 1)].energy);
      }
    }
  }
  EXPECT_GT(several, 1200);
  EXPECT_GT(grounds, 1200);
  EXPECT_LT(grounds, 2000) << "thick leaves hide the ground from some pulses";
}

TEST(Returns, NoMoreEchoesThanAskedForAndTheGroundIsAmongThem) {
  test::PlaneScene scene = plane();
  scene.canopy_east = 100.0;
  scene.canopy_density = 1.0;
  for (std::uint64_t pulse = 0; pulse < 500; ++pulse) {
    CounterRandom random(1, 2, pulse);
    EXPECT_LE(follow_pulse(scene, kDown, 2, random).count, 2);
    EXPECT_LE(follow_pulse(scene, kDown, 1, random).count, 1);
  }
}

TEST(Returns, WaterGivesRareEchoesBelowTheSensorAndNoneAside) {
  test::PlaneScene scene = plane();
  scene.water_east = 100.0;
  int below = 0, aside = 0;
  const Ray slanting{{50.0, 50.0, 600.0}, normalized(Vec3d{0.3, 0.0, -1.0})};
  for (std::uint64_t pulse = 0; pulse < 20000; ++pulse) {
    CounterRandom random(1, 2, pulse);
    below += follow_pulse(scene, kDown, 5, random).count;
    aside += follow_pulse(scene, slanting, 5, random).count;
  }
  EXPECT_GT(below, 100);
  EXPECT_LT(below, 400);
  EXPECT_EQ(aside, 0);
}

TEST(Returns, GrazingBeamsGiveNothing) {
  test::PlaneScene scene = plane();
  scene.wall_x = 60.0;
  scene.wall_height = 50.0;
  CounterRandom random(1, 2, 3);
  const Ray along_the_wall{{59.76, 50.0, 1000.0}, normalized(Vec3d{0.0005, 0.0, -1.0})};
  Hit hit;
  ASSERT_TRUE(scene.cast(along_the_wall, hit));
  ASSERT_EQ(hit.normal.x, -1.0);
  EXPECT_EQ(follow_pulse(scene, along_the_wall, 5, random).count, 0);
}

TEST(Returns, BeamsOutOfTheSceneGiveNothing) {
  CounterRandom random(1, 2, 3);
  const Ray away{{50.0, 50.0, 1700.0}, normalized(Vec3d{1.0, 0.0, -0.1})};
  EXPECT_EQ(follow_pulse(plane(), away, 5, random).count, 0);
}

TEST(Returns, NoiseOfAllAxesTogetherIsWhatWasAskedForAtTheNominalRange) {
  const NoiseOptions noise{0.03, 1200.0};
  const double across = noise.across_rad() * 1200.0, along = noise.along_m(1200.0);
  EXPECT_NEAR(std::sqrt(along * along + 2.0 * across * across), 0.03, 1e-12);
  EXPECT_GT(noise.along_m(2400.0), 1.4 * along);
  EXPECT_LT(noise.along_m(600.0), along);
}

TEST(Returns, IntensityFallsWithIncidenceRangeAndWhatLeavesTook) {
  const auto mean = [](const Echo& echo) {
    double sum = 0.0;
    for (std::uint64_t i = 0; i < 400; ++i) {
      CounterRandom random(1, 2, i);
      sum += intensity_of(echo, 1200.0, random);
    }
    return sum / 400.0;
  };
  Echo echo;
  echo.range_m = 1200.0;
  const double full = mean(echo);
  echo.cos_incidence = 0.5;
  EXPECT_NEAR(mean(echo), 0.5 * full, 0.02 * full);
  echo.cos_incidence = 1.0;
  echo.range_m = 2400.0;
  EXPECT_NEAR(mean(echo), 0.25 * full, 0.02 * full);
  echo.range_m = 1200.0;
  echo.energy = 0.3;
  EXPECT_NEAR(mean(echo), 0.3 * full, 0.02 * full);
}

}  // namespace
}  // namespace cornice::simulate
