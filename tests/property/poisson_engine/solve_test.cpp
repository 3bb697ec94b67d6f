// SPDX-License-Identifier: GPL-3.0-or-later
// The solver against surfaces that are known exactly.
#include "stages/poisson/solve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "core/base/random.h"
#include "tests/property/poisson_engine/field_reader.h"

namespace cornice {
namespace {

const Vec3d kOrigin{2600000, 1200000, 1500};

/// Adds `count` points of a surface given by two numbers in [0, 1): position and normal.
using Patch = std::function<std::pair<Vec3d, Vec3d>(double u, double v)>;
void add(OrientedPoints& points, std::size_t count, double noise_m, std::uint64_t stream,
         const Patch& patch) {
  points.origin = kOrigin;
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(7, stream, i);
    const double u = random.uniform(), v = random.uniform();
    const auto [position, normal] = patch(u, v);
    points.positions.push_back((position + normal * (noise_m * random.normal())).cast<float>());
    points.normals.push_back(normal.cast<float>());
    points.quality.push_back(1.0f);
  }
}

Patch sphere(double radius) {
  return [radius](double u, double v) {
    const double z = 2 * u - 1, r = std::sqrt(1 - z * z), a = 2 * std::numbers::pi * v;
    const Vec3d n{r * std::cos(a), r * std::sin(a), z};
    return std::pair(n * radius, n);
  };
}

/// A rectangle from `corner` along two sides; the normal is their cross product.
Patch rectangle(Vec3d corner, Vec3d along, Vec3d across) {
  const Vec3d normal = normalized(cross(along, across));
  return [=](double u, double v) { return std::pair(corner + along * u + across * v, normal); };
}

/// Rolling ground of 2 m height over a square.
Patch hills(double x0, double y0, double side) {
  return [=](double u, double v) {
    const double x = x0 + side * u, y = y0 + side * v;
    const Vec3d n = normalized(Vec3d{-2.0 / 9.0 * std::cos(x / 9) * std::cos(y / 7),
                                     2.0 / 7.0 * std::sin(x / 9) * std::sin(y / 7), 1.0});
    return std::pair(Vec3d{x, y, 2.0 * std::sin(x / 9) * std::cos(y / 7)}, n);
  };
}

Box3d bounds(const OrientedPoints& points) {
  Box3d box;
  for (const Vec3f p : points.positions) box.add(points.origin + p.cast<double>());
  return box;
}

Solution solve(const OrientedPoints& points, double step_m, int threads = 2) {
  SolveOptions options;
  options.lattice.step_m = step_m;
  options.threads = threads;
  return solve_poisson(points, bounds(points), options, no_progress());
}

/// Root mean square and share found of the distances from true places to the field's zero.
struct Accuracy {
  double rms_m = 0.0, found = 0.0;
};
Accuracy accuracy(const Field& field, int count, double reach_m, const Patch& patch) {
  double sum = 0.0;
  int found = 0;
  for (int i = 0; i < count; ++i) {
    CounterRandom random(99, 0, static_cast<std::uint64_t>(i));
    const double u = random.uniform(0.1, 0.9), v = random.uniform(0.1, 0.9);
    const auto [position, normal] = patch(u, v);
    const auto d = distance_to_zero(field, kOrigin + position, normal, reach_m);
    if (!d) continue;
    ++found;
    sum += *d * *d;
  }
  return {std::sqrt(sum / std::max(found, 1)), static_cast<double>(found) / count};
}

TEST(SolvePoisson, IsZeroOnASphereNegativeInsideAndPositiveOutside) {
  OrientedPoints points;
  add(points, 40000, 0.0, 0, sphere(10.0));
  const Field field = solve(points, 0.5).field;
  const Accuracy got = accuracy(field, 500, 0.5, sphere(10.0));
  EXPECT_EQ(got.found, 1.0);
  EXPECT_LT(got.rms_m, 0.01 * 0.5 * 2);
  EXPECT_LT(read_field(field, kOrigin)->value, -0.2);
  EXPECT_GT(read_field(field, kOrigin + Vec3d{0, 0, 13})->value, 0.2);
  const Vec3d n = normalized(Vec3d{1, -2, 2});
  EXPECT_GT(dot(normalized(read_field(field, kOrigin + n * 10.0)->gradient), n), 0.999);
}

// Screening alone would hold the surface in place; with little of it the levels must agree. Solved
// one after the other, each coarse one drew the next towards its own surface: 75 mm.
TEST(SolvePoisson, StaysOnASphereThatCoarseLevelsCannotHold) {
  OrientedPoints points;
  add(points, 6283, 0.0, 0, sphere(5.0));
  SolveOptions options;
  options.point_weight = 1.0;
  options.threads = 2;
  const Field field = solve_poisson(points, bounds(points), options, no_progress()).field;
  const Accuracy got = accuracy(field, 500, 0.5, sphere(5.0));
  EXPECT_EQ(got.found, 1.0);
  EXPECT_LT(got.rms_m, 0.04);
}

TEST(SolvePoisson, ComesCloserToASphereWithASmallerStep) {
  OrientedPoints points;
  add(points, 200000, 0.0, 0, sphere(10.0));
  const double coarse = accuracy(solve(points, 1.0).field, 400, 1.0, sphere(10.0)).rms_m;
  const double fine = accuracy(solve(points, 0.5).field, 400, 1.0, sphere(10.0)).rms_m;
  EXPECT_LT(fine, 0.5 * coarse);
}

TEST(SolvePoisson, EvensOutNoiseOnTiltedGroundAndOnALeaningWall) {
  const Patch ground = rectangle({0, 0, 0}, {30, 0, 6}, {0, 30, 3});
  // Leans out by 15 degrees: its normal points below the horizon.
  const Patch wall = rectangle({60, 0, 0}, {0, 30, 0}, {5, 0, 20});
  OrientedPoints points;
  add(points, 20 * 900, 0.03, 0, ground);
  add(points, 20 * 600, 0.03, 1, [&](double u, double v) {
    const auto [p, n] = wall(u, v);
    return std::pair(p, -n);
  });
  const Field field = solve(points, 0.5).field;
  const Accuracy on_ground = accuracy(field, 400, 0.5, ground);
  EXPECT_EQ(on_ground.found, 1.0);
  EXPECT_LT(on_ground.rms_m, 0.01);
  const Accuracy on_wall = accuracy(field, 400, 0.5, wall);
  EXPECT_EQ(on_wall.found, 1.0);
  EXPECT_LT(on_wall.rms_m, 0.01);
}

TEST(SolvePoisson, KeepsSparseGroundBesideDenseGround) {
  const Patch dense = rectangle({0, 0, 0}, {30, 0, 3}, {0, 40, 0});
  const Patch sparse = rectangle({30, 0, 3}, {30, 0, 3}, {0, 40, 0});
  OrientedPoints points;
  add(points, 20 * 1200, 0.0, 0, dense);
  add(points, 600, 0.0, 1, sparse);
  const Solution solution = solve(points, 0.5);
  EXPECT_LT(accuracy(solution.field, 300, 1.0, dense).rms_m, 0.01);
  const Accuracy got = accuracy(solution.field, 300, 2.0, sparse);
  EXPECT_EQ(got.found, 1.0);
  EXPECT_LT(got.rms_m, 0.05);
}

TEST(SolvePoisson, GivesTheSameBytesWithOneAndTwoThreads) {
  OrientedPoints points;
  add(points, 60000, 0.03, 0, hills(0, 0, 60));
  const Field one = solve(points, 0.5, 1).field, two = solve(points, 0.5, 2).field;
  ASSERT_EQ(one.levels().size(), two.levels().size());
  for (std::size_t l = 0; l < one.levels().size(); ++l) {
    EXPECT_EQ(one.levels()[l].bricks, two.levels()[l].bricks);
    EXPECT_EQ(one.levels()[l].values, two.levels()[l].values) << "level " << l;
  }
}

TEST(SolvePoisson, DoesNotDependOnTheOrderOfPointsNorOnTheirOrigin) {
  OrientedPoints points;
  add(points, 30000, 0.03, 0, hills(0, 0, 40));
  const Field field = solve(points, 0.5).field;
  OrientedPoints other = points;
  std::vector<std::size_t> order(points.positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  other.origin = kOrigin - Vec3d{64, 32, 16};
  for (std::size_t i = 0; i < order.size(); ++i) {
    other.positions[i] = points.positions[order[i]] + Vec3f{64, 32, 16};
    other.normals[i] = points.normals[order[i]];
  }
  const Field shuffled = solve(other, 0.5).field;
  ASSERT_EQ(field.levels()[0].bricks, shuffled.levels()[0].bricks);
  EXPECT_THAT(shuffled.levels()[0].values,
              testing::Pointwise(testing::FloatNear(1e-3f), field.levels()[0].values));
}

TEST(SolvePoisson, WeighsPointsByTheirQuality) {
  OrientedPoints points;
  add(points, 20 * 400, 0.0, 0, rectangle({0, 0, 0}, {20, 0, 0}, {0, 20, 0}));
  add(points, 20 * 400, 0.0, 1, rectangle({0, 0, 0.2}, {20, 0, 0}, {0, 20, 0}));
  std::fill(points.quality.begin() + 20 * 400, points.quality.end(), 0.05f);
  const Field field = solve(points, 0.5).field;
  const auto up = distance_to_zero(field, kOrigin + Vec3d{10.2, 10.3, 0}, {0, 0, 1}, 0.5);
  ASSERT_TRUE(up);
  EXPECT_NEAR(*up, 0.2 * 0.05 / 1.05, 0.01);
}

TEST(SolvePoisson, CostsByAreaNotByHeight) {
  const auto unknowns = [](double rise) {
    OrientedPoints points;
    // Four terraces, `rise` apart.
    for (int t = 0; t < 4; ++t)
      add(points, 8000, 0.0, static_cast<std::uint64_t>(t),
          rectangle({20.0 * t, 0, rise * t}, {20, 0, 0}, {0, 20, 0}));
    std::uint64_t count = 0;
    for (const LevelReport& level : solve(points, 0.5).report.levels) {
      if (level.spacing_m < 8.0) count += level.unknowns;
    }
    return static_cast<double>(count);
  };
  EXPECT_LT(unknowns(400.0), 1.5 * unknowns(5.0));
}

TEST(SolvePoisson, AgreesInAnOverlapWithAFieldOfTheWhole) {
  // Two tiles that meet at x = 60, each with 40 m of the other; and all of it in one piece.
  OrientedPoints whole, west, east;
  add(whole, 20 * 120 * 40, 0.03, 0, [](double u, double v) {
    const auto [p, n] = hills(0, 0, 120)(u, v / 3);
    return std::pair(p, n);
  });
  west.origin = east.origin = kOrigin;
  for (std::size_t i = 0; i < whole.positions.size(); ++i) {
    for (OrientedPoints* tile : {&west, &east}) {
      const float x = whole.positions[i].x;
      if (tile == &west ? x > 100.0f : x < 20.0f) continue;
      tile->positions.push_back(whole.positions[i]);
      tile->normals.push_back(whole.normals[i]);
      tile->quality.push_back(whole.quality[i]);
    }
  }
  const Field all = solve(whole, 0.5).field, left = solve(west, 0.5).field,
              right = solve(east, 0.5).field;
  double worst = 0.0, across = 0.0;
  for (double y = 2.0; y < 38.0; y += 0.37) {
    const Vec3d place = kOrigin + Vec3d{60.0, y, 2.0 * std::sin(60.0 / 9) * std::cos(y / 7)};
    const auto a = distance_to_zero(all, place, {0, 0, 1}, 0.5),
               l = distance_to_zero(left, place, {0, 0, 1}, 0.5),
               r = distance_to_zero(right, place, {0, 0, 1}, 0.5);
    ASSERT_TRUE(a && l && r);
    worst = std::max({worst, std::abs(*l - *a), std::abs(*r - *a)});
    across = std::max(across, std::abs(*l - *r));
  }
  EXPECT_LT(worst, 0.002);
  EXPECT_LT(across, 0.002);
}

TEST(SolvePoisson, ReachesASmallResidualOnEveryLevel) {
  OrientedPoints points;
  add(points, 40000, 0.03, 0, hills(0, 0, 45));
  const SolveReport report = solve(points, 0.5).report;
  for (const LevelReport& level : report.levels)
    EXPECT_LT(level.residual, 0.05) << "at " << level.spacing_m << " m";
  EXPECT_LT(std::abs(report.field_at_points), 0.01);
}

}  // namespace
}  // namespace cornice
