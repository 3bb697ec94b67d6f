// SPDX-License-Identifier: GPL-3.0-or-later
// A second opinion on nearest points: CGAL's tree, in double precision.
#include "core/mesh/triangle_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/mesh/surface_distance.h"
#include "tests/support/meshes.h"
#include "tests/support/solids.h"

namespace cornice {
namespace {

Mesh rough_ground() {
  return test::height_mesh(0, 0, 60, 0.5, [](double x, double y) {
    return 4.0 * std::sin(x / 3.0) * std::cos(y / 4.0) +
           0.1 * CounterRandom(1, static_cast<std::uint64_t>(2 * x),
                               static_cast<std::uint64_t>(2 * y))
                     .normal();
  });
}

TEST(TriangleTree, FindsTheDistancesThatCgalFinds) {
  const Mesh mesh = rough_ground();
  const TriangleTree tree(mesh.positions, mesh.triangles, 2);
  test::Solids all = test::solids(mesh);
  const test::SolidTree cgal(all.begin(), all.end());
  for (std::uint64_t i = 0; i < 3000; ++i) {
    CounterRandom random(2, 0, i);
    const Vec3f p =
        Vec3d{random.uniform(-5, 35), random.uniform(-5, 35), random.uniform(-8, 8)}.cast<float>();
    const NearestPoint found = tree.nearest(p);
    ASSERT_TRUE(found.found());
    const double expected = std::sqrt(cgal.squared_distance(test::solid_point(p)));
    EXPECT_NEAR(std::sqrt(found.distance_sq), expected, 1e-5);
    EXPECT_NEAR(norm(tree.point(found) - p), expected, 1e-5);
    // A guess, even a bad one, changes nothing.
    NearestQuery query;
    query.guess = static_cast<std::uint32_t>(random.bits() % mesh.triangles.size());
    EXPECT_EQ(tree.nearest(p, query).distance_sq, found.distance_sq);
  }
}

TEST(TriangleTree, PassesOverTrianglesThatFaceAway) {
  // Two sheets 1 m apart, the upper one turned upside down.
  Mesh mesh = test::height_mesh(0, 0, 4, 1.0, [](double, double) { return 0.0; });
  const Mesh upper = test::height_mesh(0, 0, 4, 1.0, [](double, double) { return 1.0; });
  for (const Vec3f p : upper.positions) mesh.positions.push_back(p);
  for (const auto& t : upper.triangles) {
    mesh.triangles.push_back({t[0] + 25, t[2] + 25, t[1] + 25});
  }
  const TriangleTree tree(mesh.positions, mesh.triangles, 1);
  NearestQuery query;
  query.facing = {0, 0, 1};
  EXPECT_NEAR(tree.nearest({2.2f, 1.7f, 0.9f}).distance_sq, 0.01f, 1e-5f);
  EXPECT_NEAR(tree.nearest({2.2f, 1.7f, 0.9f}, query).distance_sq, 0.81f, 1e-5f);
  query.facing = {0, 0, -1};
  EXPECT_NEAR(tree.nearest({2.2f, 1.7f, 0.1f}, query).distance_sq, 0.81f, 1e-5f);
}

TEST(TriangleTree, FindsNothingBeyondTheLargestDistanceOrInAnEmptyMesh) {
  const Mesh mesh = rough_ground();
  const TriangleTree tree(mesh.positions, mesh.triangles, 1);
  NearestQuery query;
  query.max_distance_sq = 100.0f;
  EXPECT_FALSE(tree.nearest({15, 15, 100}, query).found());
  EXPECT_TRUE(tree.nearest({15, 15, 5}, query).found());
  const Mesh none;
  EXPECT_FALSE(TriangleTree(none.positions, none.triangles, 1).nearest({0, 0, 0}).found());
}

TEST(NearestOnTriangle, TakesTrianglesWithoutArea) {
  const Vec3f a{0, 0, 0}, b{2, 0, 0};
  EXPECT_NEAR(nearest_on_triangle({1, 1, 0}, a, b, a).distance_sq, 1.0f, 1e-6f);
  EXPECT_NEAR(nearest_on_triangle({1, 1, 0}, a, a, a).distance_sq, 2.0f, 1e-6f);
}

using Wide = Vec3<long double>;

/// The distance by the triangle's plane and edges in turn, each in 64-bit digits.
double wide_distance(Vec3f pf, const std::array<Vec3f, 3>& corners) {
  const Wide p = pf.cast<long double>();
  std::array<Wide, 3> at;
  for (std::size_t k = 0; k < 3; ++k) at[k] = corners[k].cast<long double>() - p;
  const Wide n = cross(at[1] - at[0], at[2] - at[0]);
  bool inside = dot(n, n) > 0.0L;
  long double nearest_sq = dot(at[0], at[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide from = at[k], edge = at[(k + 1) % 3] - from;
    inside = inside && dot(cross(edge, -from), n) >= 0.0L;
    const long double length_sq = dot(edge, edge);
    if (!(length_sq > 0.0L)) continue;
    const Wide off = from + edge * std::clamp(-dot(from, edge) / length_sq, 0.0L, 1.0L);
    nearest_sq = std::min(nearest_sq, dot(off, off));
  }
  if (inside) nearest_sq = std::min(nearest_sq, dot(n, at[0]) * dot(n, at[0]) / dot(n, n));
  return static_cast<double>(std::sqrt(nearest_sq));
}

/// A triangle 0.1 to 200 m long and down to a micrometre wide, anywhere along whose length its
/// third corner stands.
std::array<Vec3f, 3> sliver(CounterRandom& random) {
  const auto direction = [&] {
    return normalized(Vec3d{random.normal(), random.normal(), random.normal()});
  };
  const Vec3d from = direction() * random.uniform(0.0, 100.0);
  const Vec3d along = direction() * std::pow(10.0, random.uniform(-1.0, 2.3));
  const Vec3d across = normalized(cross(along, direction()));
  const double width = norm(along) * std::pow(10.0, random.uniform(-7.0, 0.0));
  const Vec3d third = from + along * random.uniform(-0.2, 1.2) + across * width;
  return {from.cast<float>(), (from + along).cast<float>(), third.cast<float>()};
}

/// Near the triangle's length, at any of many distances from it.
Vec3f beside(const std::array<Vec3f, 3>& t, CounterRandom& random) {
  const double share = random.uniform(-0.1, 1.1);
  const Vec3d foot = t[0].cast<double>() * (1.0 - share) + t[1].cast<double>() * share;
  const double away = std::pow(10.0, random.uniform(-5.0, 1.4));
  return (foot + Vec3d{random.normal(), random.normal(), random.normal()} * away).cast<float>();
}

TEST(NearestOnTriangle, IsRightToAHundredthOfAMillimetreOnSlivers) {
  double worst = 0.0;
  for (std::uint64_t i = 0; i < 200000; ++i) {
    CounterRandom random(5, 0, i);
    const std::array<Vec3f, 3> t = sliver(random);
    const Vec3f p = beside(t, random);
    const double expected = wide_distance(p, t);
    const NearestPoint found = nearest_on_triangle(p, t[0], t[1], t[2]);
    worst = std::max(worst, std::abs(std::sqrt(static_cast<double>(found.distance_sq)) - expected));
    const TrianglePlace place = nearest_place(p.cast<double>(), t[0].cast<double>(),
                                              t[1].cast<double>(), t[2].cast<double>());
    ASSERT_GE(place.u, 0.0);
    ASSERT_GE(place.v, 0.0);
    ASSERT_LE(place.u + place.v, 1.0 + 1e-12);
  }
  EXPECT_LT(worst, 1e-5);
}

TEST(TriangleTree, FindsTheNearestOfManySliversWhateverTheGuess) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 500; ++i) {
    CounterRandom random(6, 0, i);
    for (const Vec3f p : sliver(random)) mesh.positions.push_back(p);
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const TriangleTree tree(mesh.positions, mesh.triangles, 2);
  for (std::uint64_t i = 0; i < 500; ++i) {
    CounterRandom random(7, 0, i);
    const Vec3f p =
        Vec3d{random.uniform(-150, 150), random.uniform(-150, 150), random.uniform(-150, 150)}
            .cast<float>();
    double expected = 1e9;
    for (const auto& t : mesh.triangles) {
      expected = std::min(expected, wide_distance(p, {mesh.positions[t[0]], mesh.positions[t[1]],
                                                      mesh.positions[t[2]]}));
    }
    const NearestPoint found = tree.nearest(p);
    EXPECT_NEAR(std::sqrt(static_cast<double>(found.distance_sq)), expected, 2e-5);
    NearestQuery query;
    query.guess = static_cast<std::uint32_t>(random.bits() % mesh.triangles.size());
    EXPECT_EQ(tree.nearest(p, query).triangle, found.triangle);
    query.guess = found.triangle;
    EXPECT_EQ(tree.nearest(p, query).triangle, found.triangle);
  }
}

TEST(TriangleTree, NamesTheFirstOfSeveralTrianglesAtOneDistance) {
  // A fan of 40 around a corner, met from above it, and the same fan again.
  Mesh mesh;
  mesh.positions.push_back({0, 0, 1});
  for (int k = 0; k < 40; ++k) {
    const double turn = 0.05 * std::numbers::pi * k;
    mesh.positions.push_back(Vec3d{std::cos(turn), std::sin(turn), 0.0}.cast<float>());
  }
  for (int copy = 0; copy < 2; ++copy) {
    for (std::uint32_t k = 0; k < 40; ++k) mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % 40});
  }
  const TriangleTree tree(mesh.positions, mesh.triangles, 1);
  for (std::uint32_t guess = 0; guess < 80; ++guess) {
    NearestQuery query;
    query.guess = guess;
    EXPECT_EQ(tree.nearest({0, 0, 3}, query).triangle, 0u);
    EXPECT_EQ(tree.nearest({0, 0, 3}, query).distance_sq, 4.0f);
  }
}

TEST(LargestDistance, OfASphereToALargerOneIsTheDifferenceOfTheirRadii) {
  const Mesh inner = test::sphere_mesh(10.0, 5), outer = test::sphere_mesh(10.5, 5);
  const TriangleTree from(inner.positions, inner.triangles, 2);
  const TriangleTree to(outer.positions, outer.triangles, 2);
  const SurfaceDistance distance = measure_distance(from, to, 0.2f, 2);
  // Facets of 0.35 m lie up to 1.5 mm under their sphere.
  EXPECT_NEAR(distance.forth_m, 0.5f, 3e-3f);
  EXPECT_NEAR(distance.back_m, 0.5f, 3e-3f);
}

TEST(LargestDistance, IsThatOfTheWorstSampleWhateverTheThreads) {
  const Mesh ground = rough_ground();
  const Mesh flat = test::height_mesh(0, 0, 1, 30.0, [](double, double) { return 0.0; });
  const TriangleTree rough(ground.positions, ground.triangles, 2);
  const TriangleTree even(flat.positions, flat.triangles, 2);
  float highest = 0.0f;
  for (const Vec3f p : ground.positions) highest = std::max(highest, std::abs(p.z));
  const SurfaceDistance one = measure_distance(rough, even, 0.25f, 1);
  EXPECT_NEAR(one.forth_m, highest, 1e-5f);
  EXPECT_GT(one.back_m, 0.0f);
  EXPECT_EQ(one.forth_m, measure_distance(rough, even, 0.25f, 2).forth_m);
  EXPECT_EQ(one.back_m, measure_distance(rough, even, 0.25f, 2).back_m);
}

}  // namespace
}  // namespace cornice
