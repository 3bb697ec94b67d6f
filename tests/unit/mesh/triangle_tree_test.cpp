// SPDX-License-Identifier: GPL-3.0-or-later
// A second opinion on nearest points: CGAL's tree, in double precision.
#include "core/mesh/triangle_tree.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "core/mesh/surface_distance.h"
#include "tests/support/meshes.h"

namespace cornice {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Solids = std::vector<Kernel::Triangle_3>;
using Tree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Solids::iterator>>>;

Kernel::Point_3 point(Vec3f p) { return {p.x, p.y, p.z}; }

Solids solids(const Mesh& mesh) {
  Solids all;
  for (const auto& t : mesh.triangles) {
    all.emplace_back(point(mesh.positions[t[0]]), point(mesh.positions[t[1]]),
                     point(mesh.positions[t[2]]));
  }
  return all;
}

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
  Solids all = solids(mesh);
  const Tree cgal(all.begin(), all.end());
  for (std::uint64_t i = 0; i < 3000; ++i) {
    CounterRandom random(2, 0, i);
    const Vec3f p =
        Vec3d{random.uniform(-5, 35), random.uniform(-5, 35), random.uniform(-8, 8)}.cast<float>();
    const NearestPoint found = tree.nearest(p);
    ASSERT_TRUE(found.found());
    const double expected = std::sqrt(cgal.squared_distance(point(p)));
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
