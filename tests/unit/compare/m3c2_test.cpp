// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/m3c2.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "stages/compare/point_grid.h"
#include "tests/unit/compare/pieces.h"

namespace cornice::compare {
namespace {

constexpr Box2d kBox{5, 5, 25, 25};

/// Points of a plane that rises by `slope` to the east, moved along its normal.
Surface noisy_plane(double slope, double along_normal_m, double noise_m, std::uint64_t seed) {
  const Vec3d normal = normalized(Vec3d{-slope, 0.0, 1.0});
  std::vector<Vec3f> points;
  for (std::uint64_t i = 0; i < 18000; ++i) {
    CounterRandom random(seed, 0, i);
    const double x = random.uniform(0, 30), y = random.uniform(0, 30);
    const Vec3d p = Vec3d{x, y, slope * x} + normal * (along_normal_m + noise_m * random.normal());
    points.push_back(p.cast<float>());
  }
  return test::cloud_of(std::move(points));
}

TEST(PointGrid, FindsAllThatSearchingEveryPointFinds) {
  std::vector<Vec3f> points;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    CounterRandom random(8, 0, i);
    points.push_back(
        Vec3d{random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9)}.cast<float>());
  }
  const PointGrid grid(points, 0.7f);
  for (std::size_t q = 0; q < 50; ++q) {
    const Vec3f p = points[q * 37];
    std::size_t found = 0, expected = 0;
    grid.visit_near(p, 1.5f, [&](std::uint32_t i) { found += norm(points[i] - p) <= 1.5f; });
    for (const Vec3f other : points) expected += norm(other - p) <= 1.5f;
    EXPECT_EQ(found, expected);
  }
}

TEST(M3c2, FindsAShiftAlongTheNormalOfASteepPlane) {
  const Surface a = noisy_plane(1.5, 0.0, 0.03, 1), b = noisy_plane(1.5, 0.4, 0.03, 2);
  const std::vector<M3c2Point> points = m3c2_points(a, b, kBox, {}, 2);
  ASSERT_GT(points.size(), 300u);
  std::size_t measured = 0;
  double sum = 0.0;
  for (const M3c2Point& p : points) {
    if (std::isnan(p.distance_m)) continue;
    ++measured;
    sum += static_cast<double>(p.distance_m);
    EXPECT_NEAR(p.distance_m, 0.4, 0.08);
    EXPECT_TRUE(p.is_significant());
    EXPECT_NEAR(p.normal.z, 1.0 / std::hypot(1.5, 1.0), 0.05);
  }
  EXPECT_GT(measured, points.size() * 9 / 10);
  EXPECT_NEAR(sum / static_cast<double>(measured), 0.4, 0.004);
}

TEST(M3c2, CallsNineteenOfTwentyInsignificantWhereNothingChanged) {
  const Surface a = noisy_plane(0.5, 0.0, 0.05, 3), b = noisy_plane(0.5, 0.0, 0.05, 4);
  std::size_t measured = 0, significant = 0;
  for (const M3c2Point& p : m3c2_points(a, b, kBox, {}, 1)) {
    if (std::isnan(p.distance_m)) continue;
    ++measured;
    significant += p.is_significant();
  }
  ASSERT_GT(measured, 300u);
  EXPECT_LT(static_cast<double>(significant) / static_cast<double>(measured), 0.10);
  EXPECT_GT(significant, 0u);
}

TEST(M3c2, WidensItsLevelByTheRegistrationError) {
  const Surface a = noisy_plane(0.0, 0.0, 0.02, 5), b = noisy_plane(0.0, 0.2, 0.02, 6);
  M3c2Options options;
  options.registration_m = 0.15;
  for (const M3c2Point& p : m3c2_points(a, b, kBox, options, 1)) {
    if (std::isnan(p.distance_m)) continue;
    EXPECT_FALSE(p.is_significant());
  }
}

TEST(M3c2, IsTheSameOnOneAndOnTwoThreads) {
  const Surface a = noisy_plane(1.0, 0.0, 0.03, 1), b = noisy_plane(1.0, 0.1, 0.03, 2);
  const auto one = m3c2_points(a, b, kBox, {}, 1), two = m3c2_points(a, b, kBox, {}, 2);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].position, two[i].position);
    EXPECT_EQ(std::isnan(one[i].distance_m), std::isnan(two[i].distance_m));
    if (std::isnan(one[i].distance_m)) continue;
    EXPECT_EQ(one[i].distance_m, two[i].distance_m);
  }
}

}  // namespace
}  // namespace cornice::compare
