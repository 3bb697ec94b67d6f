// SPDX-License-Identifier: GPL-3.0-or-later
// Input that no surface comes out of, or hardly one.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "stages/poisson/solve.h"
#include "tests/property/poisson_engine/field_reader.h"

namespace cornice {
namespace {

const Vec3d kOrigin{2600000, 1200000, 1500};
const Box3d kDomain{kOrigin - Vec3d{2000, 2000, 2000}, kOrigin + Vec3d{2000, 2000, 2000}};

OrientedPoints flat_ground(double side, double per_m2) {
  OrientedPoints points;
  points.origin = kOrigin;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(side * side * per_m2); ++i) {
    CounterRandom random(5, 0, i);
    const auto x = static_cast<float>(random.uniform(0, side)),
               y = static_cast<float>(random.uniform(0, side));
    points.positions.push_back({x, y, 0.1f});
    points.normals.push_back({0, 0, 1});
  }
  return points;
}

Solution solve(const OrientedPoints& points, const SolveOptions& options = {},
               const Box3d& domain = kDomain) {
  return solve_poisson(points, domain, options, no_progress());
}

void expect_finite(const Field& field) {
  for (const FieldLevel& level : field.levels()) {
    for (const float value : level.values) ASSERT_TRUE(std::isfinite(value));
  }
}

void expect_ground(const Field& field, double x, double y) {
  const auto up = distance_to_zero(field, kOrigin + Vec3d{x, y, 0.1}, {0, 0, 1}, 1.0);
  ASSERT_TRUE(up);
  EXPECT_NEAR(*up, 0.0, 0.01);
}

TEST(DegenerateInput, WithoutPointsIsBadInput) {
  EXPECT_THROW(solve({}), InputError);
  EXPECT_THROW(solve(flat_ground(5, 4), {}, Box3d{}), InputError);
}

TEST(DegenerateInput, WithoutAnyNormalOrQualityIsBadInputThatSaysSo) {
  OrientedPoints points = flat_ground(5, 4);
  points.normals.assign(points.positions.size(), {});
  try {
    solve(points);
    FAIL() << "points without normals were accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("100 have no normal"), std::string::npos)
        << error.what();
  }
  points = flat_ground(5, 4);
  points.quality.assign(points.positions.size(), 0.0f);
  EXPECT_THROW(solve(points), InputError);
}

TEST(DegenerateInput, OfOneOrThreePointsGivesAFiniteFieldThatRisesAlongTheirNormals) {
  for (const std::size_t count : {1u, 3u}) {
    OrientedPoints points;
    points.origin = kOrigin;
    for (std::size_t i = 0; i < count; ++i) {
      points.positions.push_back({static_cast<float>(i), 0.3f, 0.2f});
      points.normals.push_back({0, 0, 1});
    }
    const Solution solution = solve(points);
    EXPECT_EQ(solution.report.points, count);
    expect_finite(solution.field);
    const auto at = read_field(solution.field, kOrigin + Vec3d{0.1, 0.3, 0.2});
    ASSERT_TRUE(at);
    EXPECT_GT(at->gradient.z, 0.0);
  }
}

TEST(DegenerateInput, OfOppositeNormalsGivesAFiniteField) {
  OrientedPoints points = flat_ground(20, 20);
  for (std::size_t i = 0; i < points.normals.size(); i += 2) points.normals[i] = {0, 0, -1};
  expect_finite(solve(points).field);
  points = flat_ground(1, 1);
  points.positions.assign(2, {0.5f, 0.5f, 0.5f});
  points.normals = {{0, 0, 1}, {0, 0, -1}};
  expect_finite(solve(points).field);
}

TEST(DegenerateInput, WithOnePointAMillionTimesKeepsTheGroundAroundIt) {
  OrientedPoints points = flat_ground(30, 20);
  points.positions.resize(points.positions.size() + 1000000, {15.2f, 15.1f, 0.1f});
  points.normals.resize(points.positions.size(), {0, 0, 1});
  const Field field = solve(points).field;
  expect_finite(field);
  expect_ground(field, 15.2, 15.1);
  expect_ground(field, 12.3, 16.2);
  expect_ground(field, 7.0, 22.0);
}

TEST(DegenerateInput, OfAMillionCopiesAloneIsFinite) {
  OrientedPoints points;
  points.origin = kOrigin;
  points.positions.assign(1000000, {0.3f, 0.3f, 0.3f});
  points.normals.assign(1000000, {0, 0, 1});
  expect_finite(solve(points).field);
}

TEST(DegenerateInput, WithAPointAKilometreAwayKeepsTheGround) {
  for (const Vec3f stray : {Vec3f{1000, 700, 0}, Vec3f{5, 5, 1000}, Vec3f{5, 5, -1000}}) {
    OrientedPoints points = flat_ground(30, 20);
    points.positions.push_back(stray);
    points.normals.push_back({0, 0, 1});
    const Solution solution = solve(points);
    expect_finite(solution.field);
    expect_ground(solution.field, 15.2, 15.1);
    expect_ground(solution.field, 5.0, 5.0);
  }
}

TEST(DegenerateInput, OnLatticeNodesExactlyIsNothingSpecial) {
  OrientedPoints points;
  points.origin = kOrigin;
  for (int x = -40; x <= 40; ++x) {
    for (int y = -40; y <= 40; ++y) {
      points.positions.push_back(
          {0.5f * static_cast<float>(x), 0.5f * static_cast<float>(y), 4.0f});
      points.normals.push_back({0, 0, 1});
    }
  }
  const Field field = solve(points).field;
  const auto up = distance_to_zero(field, kOrigin + Vec3d{1.2, -3.1, 4.0}, {0, 0, 1}, 1.0);
  ASSERT_TRUE(up);
  EXPECT_NEAR(*up, 0.0, 0.01);
}

TEST(DegenerateInput, ThatIsNoNumberIsLeftOutAndCounted) {
  OrientedPoints points = flat_ground(20, 20);
  const std::size_t good = points.positions.size();
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  for (const Vec3f p : {Vec3f{nan, 0, 0}, Vec3f{0, infinity, 0}, Vec3f{1, 1, -infinity}}) {
    points.positions.push_back(p);
    points.normals.push_back({0, 0, 1});
  }
  points.positions.push_back({1, 1, 0});
  points.normals.push_back({0, nan, 0});
  points.positions.push_back({1, 1, 0});
  points.normals.push_back({0, 0, 0});
  points.positions.push_back({1, 1, 3000});
  points.normals.push_back({0, 0, 1});
  const Solution solution = solve(points);
  EXPECT_EQ(solution.report.points, good);
  EXPECT_EQ(solution.report.not_finite, 4u);
  EXPECT_EQ(solution.report.without_normal, 1u);
  EXPECT_EQ(solution.report.outside, 1u);
  expect_finite(solution.field);
  expect_ground(solution.field, 10.0, 10.0);
}

TEST(SolveOptions, OutOfRangeAreRefusedByName) {
  const OrientedPoints points = flat_ground(5, 4);
  const auto refused = [&](auto change) {
    SolveOptions options;
    change(options);
    try {
      solve(points, options);
    } catch (const UsageError& error) {
      return error.subject();
    }
    return std::string("accepted");
  };
  const double nan = std::nan("");
  for (const double bad : {0.0, -1.0, 1e-4, 1e4, nan})
    EXPECT_EQ(refused([&](SolveOptions& o) { o.lattice.step_m = bad; }), "--step");
  for (const double bad : {-1.0, 1e4, nan})
    EXPECT_EQ(refused([&](SolveOptions& o) { o.point_weight = bad; }), "--point-weight");
  for (const double bad : {0.0, -1.0, 101.0, nan})
    EXPECT_EQ(refused([&](SolveOptions& o) { o.points_per_cell = bad; }), "--points-per-cell");
  for (const int bad : {0, -1, 1001})
    EXPECT_EQ(refused([&](SolveOptions& o) { o.relaxations = bad; }), "--relaxations");
}

TEST(SolveOptions, RefuseADomainTooFarOutOrTooWideForTheStep) {
  OrientedPoints points = flat_ground(5, 4);
  Box3d far{kOrigin, kOrigin + Vec3d{1e9, 10, 10}};
  EXPECT_THROW(solve(points, {}, far), UsageError);
  SolveOptions fine;
  fine.lattice.step_m = 0.005;
  const Box3d wide{kOrigin - Vec3d{50000, 50000, 9000}, kOrigin + Vec3d{50000, 50000, 9000}};
  EXPECT_THROW(solve(points, fine, wide), UsageError);
}

TEST(SolvePoisson, StopsWhenItsCallerSaysSo) {
  struct Impatient : Progress {
    bool cancelled() const override { return true; }
  } impatient;
  EXPECT_THROW(solve_poisson(flat_ground(5, 4), kDomain, {}, impatient), Cancelled);
}

}  // namespace
}  // namespace cornice
