// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "stages/compare/distance_field.h"
#include "stages/compare/refine.h"
#include "stages/compare/sampling.h"
#include "tests/support/meshes.h"
#include "tests/unit/compare/pieces.h"

namespace cornice::compare {
namespace {

using test::cloud_of;
using test::surface_of;

/// Two slopes that meet in a sharp ridge along y at height 0: a roof of 45 degrees.
Surface roof() {
  return surface_of(
      test::height_mesh(-8, -8, 16, 1.0, [](double x, double) { return -std::abs(x); }));
}

TEST(SignedDistance, IsThatFromASphereToLessThanAMillimetre) {
  const Surface sphere = surface_of(test::sphere_mesh(10.0, 7));
  const DistanceField field(sphere, 2);
  // The faces lie at most this far inside the sphere: edges of 0.09 m on a radius of 10 m.
  constexpr double kChord = 0.0003;
  CounterRandom random(1, 0, 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec3d direction = normalized(Vec3d{random.normal(), random.normal(), random.normal()});
    const double radius = random.uniform(5.0, 15.0);
    const Foot foot = field.at((direction * radius).cast<float>(), 20.0f);
    ASSERT_TRUE(foot.found());
    EXPECT_FALSE(foot.beside);
    EXPECT_NEAR(foot.distance_m, radius - 10.0, kChord + 1e-4);
  }
}

TEST(SignedDistance, IsExactToAPlaneFarFromTheZeroOfCoordinates) {
  const Surface plane = surface_of(
      test::height_mesh(0, 0, 40, 2.5, [](double x, double y) { return 0.5 * x - 0.25 * y; }),
      {2600000.0, 1200000.0, 1500.0});
  const DistanceField field(plane, 1);
  const Vec3d normal = normalized(Vec3d{-0.5, 0.25, 1.0});
  CounterRandom random(2, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform(20.0, 80.0), y = random.uniform(20.0, 80.0);
    const double off = random.uniform(-9.0, 9.0);
    const Vec3d p = Vec3d{x, y, 0.5 * x - 0.25 * y} + normal * off;
    EXPECT_NEAR(field.at(p.cast<float>(), 25.0f).distance_m, off, 5e-5);
  }
}

TEST(SignedDistance, EqualsThatOfEveryTriangleTriedInTurn) {
  const Surface ledge = surface_of(test::overhang_mesh(40.0, 8.0, 6.0, 0.8));
  const DistanceField field(ledge, 2);
  CounterRandom random(3, 0, 0);
  for (int i = 0; i < 300; ++i) {
    const Vec3d drawn{random.uniform(-5, 60), random.uniform(-3, 11), random.uniform(-6, 24)};
    const Vec3f p = drawn.cast<float>();
    float nearest_sq = 1e30f;
    for (const Triangle& t : ledge.triangles) {
      const NearestPoint here = nearest_on_triangle(p, ledge.positions[t[0]], ledge.positions[t[1]],
                                                    ledge.positions[t[2]]);
      nearest_sq = std::min(nearest_sq, here.distance_sq);
    }
    EXPECT_NEAR(std::abs(field.at(p, 100.0f).distance_m), std::sqrt(nearest_sq), 1e-4);
  }
}

TEST(SignedDistance, KeepsMillimetresOnTheLongThinTrianglesOfADemsWall) {
  // 120 m high, half a metre wide and deep, ragged along its top.
  const auto top = [](int column) { return 120.0 + 0.4 * std::sin(1.7 * column); };
  const Surface wall = surface_of(test::grid_mesh(120, 2, [&](int column, int row) {
    return Vec3d{0.5 * column, 0.5 * row, row == 0 ? 0.0 : top(column)};
  }));
  const DistanceField field(wall, 1);
  CounterRandom random(4, 0, 0);
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double x = random.uniform(10, 50), z = random.uniform(5, 110);
    const Vec3d p = Vec3d{x, random.uniform(-8, 8), z}.cast<float>().cast<double>();
    double nearest = 1e9;
    for (const Triangle& t : wall.triangles) {
      // Far triangles are left out; planes of near ones are nearly one plane.
      const Vec3d a = wall.positions[t[0]].cast<double>(), b = wall.positions[t[1]].cast<double>(),
                  c = wall.positions[t[2]].cast<double>();
      if (std::abs(a.x - x) > 4.0) continue;
      const Vec3d n = normalized(cross(b - a, c - a));
      const Vec3d q = p - n * dot(p - a, n);
      const Vec3d corner[3]{a, b, c};
      bool inside = true;
      for (int k = 0; k < 3; ++k) {
        const Vec3d from = corner[k], edge = corner[(k + 1) % 3] - from;
        inside = inside && dot(cross(edge, q - from), n) >= 0.0;
        const double share = std::clamp(dot(p - from, edge) / dot(edge, edge), 0.0, 1.0);
        nearest = std::min(nearest, norm(p - from - edge * share));
      }
      if (inside) nearest = std::min(nearest, norm(p - q));
    }
    worst = std::max(
        worst, std::abs(std::abs(static_cast<double>(field.at(p.cast<float>(), 25.0f).distance_m)) -
                        nearest));
  }
  EXPECT_LT(worst, 0.001);
}

TEST(SignedDistance, HasTheRightSignAcrossARidgeWhereOneFaceAloneWouldErr) {
  const Surface surface = roof();
  const DistanceField field(surface, 1);
  // Nearest is the ridge; seen from the far slope's plane alone these would change sides.
  for (const float x : {-0.9f, -0.3f, 0.0f, 0.4f, 0.95f}) {
    EXPECT_GT(field.at({x, 0.3f, 1.0f}, 5.0f).distance_m, 0.0f) << x;
    EXPECT_LT(field.at({x, 0.3f, -1.5f}, 5.0f).distance_m, 0.0f) << x;
  }
  EXPECT_NEAR(field.at({0.0f, 0.3f, 2.0f}, 5.0f).distance_m, 2.0f, 1e-6f);
}

TEST(SignedDistance, IsNoneBeyondTheLargestAndSaysWhatLiesPastAnEdge) {
  const Surface surface = roof();
  const DistanceField field(surface, 1);
  EXPECT_FALSE(field.at({0, 0, 30}, 5.0f).found());
  EXPECT_TRUE(field.at({0, 12, 0}, 5.0f).beside);
  EXPECT_FALSE(field.at({0, 7.5f, 1}, 5.0f).beside);
  // Above the very edge is above the surface.
  EXPECT_FALSE(field.at({0, 8.0f, 0.5f}, 5.0f).beside);
}

TEST(SignedDistance, OfCloudsIsThatToTheNearestPoint) {
  const Surface cloud = cloud_of({{0, 0, 0}, {10, 0, 0}, {0, 10, 5}});
  const DistanceField field(cloud, 1);
  EXPECT_NEAR(field.at({9, 1, 0}, 25.0f).distance_m, std::sqrt(2.0f), 1e-6f);
  EXPECT_NEAR(field.at({0, 10, 2}, 25.0f).distance_m, 3.0f, 1e-6f);
  EXPECT_EQ(field.at({9, 1, 0}, 25.0f).triangle, 1u);
}

TEST(Samples, AreAsManyAsTheAreaAsksForWhateverTheTriangles) {
  const auto flat = [](double, double) { return 0.0; };
  for (const double step : {0.1, 0.7, 20.0}) {
    const int cells = static_cast<int>(std::lround(70.0 / step));
    const Surface surface = surface_of(test::height_mesh(0, 0, cells, step, flat));
    std::vector<Sample> samples;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      sample_triangle(surface, t, 0.5, 7, samples);
    }
    const double area = cells * step * (cells * step);
    EXPECT_NEAR(static_cast<double>(samples.size()), 4.0 * area, 0.02 * 4.0 * area) << step;
    double east = 0.0;
    for (const Sample& s : samples) east += static_cast<double>(s.position.x);
    EXPECT_NEAR(east / static_cast<double>(samples.size()), 0.5 * cells * step, 0.02 * 70.0);
  }
}

TEST(Samples, AreTheSameOnOneAndOnTwoThreads) {
  const Surface sphere = surface_of(test::sphere_mesh(10.0, 5));
  const Surface larger = surface_of(test::sphere_mesh(10.5, 4));
  const DistanceField field(larger, 1);
  const auto everywhere = [](double, double) { return true; };
  const auto one = measure_samples(sphere, field, {}, 0.15, 5.0, 9, everywhere, 1);
  const auto two = measure_samples(sphere, field, {}, 0.15, 5.0, 9, everywhere, 2);
  ASSERT_EQ(one.size(), two.size());
  ASSERT_GT(one.size(), 50000u);
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].distance_m, two[i].distance_m);
    ASSERT_LT(one[i].distance_m, 0.0f);
  }
}

TEST(Welding, JoinsBordersOfTilesButNotOneTilesOwnSlit) {
  const auto height = [](double x, double) { return 0.1 * x; };
  Surface both = surface_of(test::height_mesh(0, 0, 4, 1.0, height));
  const Surface east = surface_of(test::height_mesh(4, 0, 4, 1.0, height));
  std::vector<std::uint32_t> piece(both.positions.size(), 0);
  const auto first = static_cast<std::uint32_t>(both.positions.size());
  for (const Vec3f p : east.positions) both.positions.push_back(p + Vec3f{2e-4f, 0, 0});
  for (const Triangle& t : east.triangles) {
    both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  piece.resize(both.positions.size(), 1);
  const std::size_t open_before =
      check_topology(both.triangles, both.positions.size(), 1).open_edges;
  weld_borders(both, piece, 5e-4f, 1);
  const TopologyReport after = check_topology(both.triangles, both.positions.size(), 1);
  EXPECT_EQ(open_before, 32u);
  EXPECT_EQ(after.open_edges, 24u);
  EXPECT_EQ(after.components, 1u);
}

TEST(Refining, HalvesLongEdgesAndLeavesTheSurfaceWhereItIs) {
  Surface wall = surface_of(test::grid_mesh(5, 2, [](int column, int row) {
    return Vec3d{1.0 * column, 0.2 * row, 30.0 * row};
  }));
  const Surface before = wall;
  std::vector<std::uint8_t> marks(wall.triangles.size(), 0);
  marks[0] = 1;
  refine_long_edges(wall, marks, 2.0f);
  EXPECT_EQ(marks.size(), wall.triangles.size());
  double area = 0.0, marked = 0.0;
  for (std::size_t t = 0; t < wall.triangles.size(); ++t) {
    const Triangle& c = wall.triangles[t];
    const Vec3f a = wall.positions[c[0]], b = wall.positions[c[1]], d = wall.positions[c[2]];
    EXPECT_LE(norm(b - a), 2.0f);
    EXPECT_LE(norm(d - b), 2.0f);
    EXPECT_LE(norm(a - d), 2.0f);
    const double own = 0.5 * static_cast<double>(norm(cross(b - a, d - a)));
    area += own;
    if (marks[t] != 0) marked += own;
  }
  const double whole = 4.0 * std::hypot(0.2, 30.0);
  EXPECT_NEAR(area, whole, 1e-3);
  EXPECT_NEAR(marked, whole / 8.0, 1e-3);
  const TopologyReport topology = check_topology(wall.triangles, wall.positions.size(), 1);
  EXPECT_TRUE(topology.is_manifold());
  EXPECT_EQ(topology.components, 1u);
  const DistanceField field(before, 1);
  for (const Vec3f p : wall.positions) {
    EXPECT_NEAR(field.at(p, 1.0f).distance_m, 0.0f, 1e-4f);
  }
}

}  // namespace
}  // namespace cornice::compare
