// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/random.h"

namespace cornice {
namespace {

/// Points on a rolling ground with a wall, and a gap in the middle.
OrientedPoints ground_points(std::uint64_t seed, int count, double size) {
  OrientedPoints points;
  points.origin = {1000.0, 2000.0, 300.0};
  for (int i = 0; i < count; ++i) {
    CounterRandom random(seed, 1, static_cast<std::uint64_t>(i));
    double x = random.uniform(-5, size + 5);
    const double y = random.uniform(-5, size + 5);
    double z = 2.0 * std::sin(0.3 * x) + 0.2 * y;
    if (i % 4 == 0) x = 3.0, z = random.uniform(0, 30);
    if (std::abs(x - 0.6 * size) < 0.17 * size && std::abs(y - 0.5 * size) < 0.17 * size) continue;
    points.positions.push_back(Vec3d{x, y, z}.cast<float>());
  }
  return points;
}

/// Vertices near the points and far from them, not in any order of use.
Mesh vertices(int count, double size) {
  Mesh mesh;
  mesh.origin = {1000.5, 1999.0, 310.0};
  for (int i = 0; i < count; ++i) {
    CounterRandom random(9, 2, static_cast<std::uint64_t>(i));
    mesh.positions.push_back(
        Vec3d{random.uniform(0, size), random.uniform(0, size), random.uniform(-14, 20)}
            .cast<float>());
  }
  return mesh;
}

TEST(Support, IsTheDistanceToTheNearestPointAndTheCountAroundAsByLookingAtAll) {
  const double size = 60.0;
  const OrientedPoints points = ground_points(1, 20'000, size);
  const Mesh mesh = vertices(3000, size);
  for (const auto& [cap, radius] : {std::pair{16.0, 1.0}, {5.0, 2.5}, {40.0, 0.5}}) {
    SupportOptions options;
    options.cap_m = cap, options.radius_m = radius;
    const Support support = measure_support(mesh, points, options);
    std::size_t capped = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3d at = mesh.positions[v].cast<double>() + mesh.origin;
      double least = cap;
      int surely = 0, perhaps = 0;
      for (const Vec3f p : points.positions) {
        const double d = norm(p.cast<double>() + points.origin - at);
        least = std::min(least, d);
        surely += d < radius - 1e-4;
        perhaps += d < radius + 1e-4;
      }
      capped += least == cap;
      ASSERT_NEAR(support.distance_m[v], least, 2e-5) << v;
      const double counted = support.density[v] * std::numbers::pi * radius * radius;
      ASSERT_GE(counted, surely - 0.01);
      ASSERT_LE(counted, perhaps + 0.01);
    }
    if (cap < 10) {
      EXPECT_GT(capped, 100u);
    }
  }
}

TEST(Support, WithoutPointsEveryDistanceIsTheCap) {
  const Mesh mesh = vertices(10, 5.0);
  const Support support = measure_support(mesh, OrientedPoints{}, SupportOptions{});
  EXPECT_EQ(support.distance_m, std::vector<float>(10, 16.0f));
  EXPECT_EQ(support.density, std::vector<float>(10, 0.0f));
}

TEST(Support, AMeshWithoutVerticesHasNone) {
  EXPECT_TRUE(measure_support(Mesh{}, ground_points(1, 10, 5.0), {}).distance_m.empty());
}

TEST(Support, PointsThatAreNotFiniteOrVeryFarCountForNothing) {
  Mesh mesh = vertices(10, 5.0);
  OrientedPoints points;
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  points.positions = {{nan, 0, 0}, {0, nan, 0},   {0, 0, nan},
                      {inf, 0, 0}, {1e30f, 0, 0}, {0, 0, -inf}};
  const Support support = measure_support(mesh, points, {});
  EXPECT_EQ(support.distance_m, std::vector<float>(10, 16.0f));
}

TEST(Support, DensityOnFlatGroundIsThatOfThePoints) {
  OrientedPoints points;
  for (int i = 0; i < 20 * 40 * 40; ++i) {
    CounterRandom random(3, 3, static_cast<std::uint64_t>(i));
    points.positions.push_back(
        Vec3d{random.uniform(-10, 30), random.uniform(-10, 30), 0.0}.cast<float>());
  }
  Mesh mesh;
  for (int i = 0; i < 400; ++i) {
    mesh.positions.push_back({static_cast<float>(i % 20), static_cast<float>(i / 20), 0.0f});
  }
  const Support support = measure_support(mesh, points, {});
  double mean = 0.0;
  for (const float d : support.density) mean += d / 400.0;
  EXPECT_NEAR(mean, 20.0, 0.5);
}

TEST(Support, TheNumberOfThreadsChangesNoByte) {
  const OrientedPoints points = ground_points(5, 30'000, 80.0);
  const Mesh mesh = vertices(20'000, 80.0);
  SupportOptions options;
  options.threads = 1;
  const Support one = measure_support(mesh, points, options);
  options.threads = 2;
  const Support two = measure_support(mesh, points, options);
  EXPECT_EQ(one.distance_m, two.distance_m);
  EXPECT_EQ(one.density, two.density);
}

}  // namespace
}  // namespace cornice
