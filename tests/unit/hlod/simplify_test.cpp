// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/surface_distance.h"
#include "core/mesh/topology.h"
#include "core/mesh/triangle_tree.h"
#include "hlod/octahedral.h"
#include "hlod/octahedral_lanes.h"
#include "hlod/position_table.h"
#include "hlod/simplify_error.h"
#include "tests/support/meshes.h"

namespace cornice::hlod {
namespace {

SimplifyMesh block_of(const Mesh& mesh, float scale = 64) {
  SimplifyMesh block;
  for (const Vec3f& p : mesh.positions) {
    block.positions.push_back(
        {std::round(scale * p.x), std::round(scale * p.y), std::round(scale * p.z)});
  }
  block.locked.assign(block.positions.size(), 0);
  block.triangles = mesh.triangles;
  return block;
}

SimplifyMesh rough_ground(int side) {
  return block_of(test::height_mesh(0, 0, side, 1, [](double x, double y) {
    const auto key = static_cast<std::uint64_t>(x * 977 + y);
    return 6 * std::sin(x / 7) * std::cos(y / 9) + 0.4 * CounterRandom(3, 1, key).uniform();
  }));
}

std::vector<Triangle> remaining(const SimplifyMesh& mesh) {
  std::vector<Triangle> triangles;
  for (const Triangle& t : mesh.triangles) {
    if (t[0] != kNone) triangles.push_back(t);
  }
  return triangles;
}

float plan_area(const SimplifyMesh& mesh, const Triangle& t) {
  const Vec3f a = mesh.positions[t[0]];
  return cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a).z;
}

TEST(Simplify, ReachesItsTargetWithoutFoldsOrBadEdges) {
  SimplifyMesh mesh = rough_ground(60);
  const std::size_t before = mesh.triangles.size();
  Simplifier simplifier;
  SimplifyOptions options;
  options.target_triangles = before / 4;
  options.in_plan = true;
  simplifier.run(mesh, options);
  const std::vector<Triangle> left = remaining(mesh);
  EXPECT_EQ(left.size(), simplifier.triangle_count());
  EXPECT_LE(left.size(), before / 4);
  EXPECT_GE(left.size() + 2, before / 4);
  double area = 0;
  for (const Triangle& t : left) {
    EXPECT_GT(plan_area(mesh, t), 0);
    area += 0.5 * double{plan_area(mesh, t)};
  }
  EXPECT_NEAR(area, 60.0 * 60 * 64 * 64, 0.002 * 60 * 60 * 64 * 64);
  const TopologyReport report = check_topology(left, mesh.positions.size(), 1);
  EXPECT_EQ(report.non_manifold_edges, 0u);
  EXPECT_EQ(report.degenerate_triangles, 0u);
  EXPECT_EQ(report.duplicate_triangles, 0u);
}

TEST(Simplify, MovesNoVertexFartherThanItsReach) {
  for (const bool in_plan : {true, false}) {
    SimplifyMesh mesh = rough_ground(40);
    Simplifier simplifier;
    SimplifyOptions options;
    options.reach = 100;
    options.in_plan = in_plan;
    simplifier.run(mesh, options);
    EXPECT_LT(remaining(mesh).size(), mesh.triangles.size() / 2);
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3f d = mesh.positions[simplifier.parents()[v]] - mesh.positions[v];
      EXPECT_LE(std::max(std::abs(d.x), std::abs(d.y)), 100);
      if (!in_plan) {
        EXPECT_LE(std::abs(d.z), 100);
      }
    }
  }
}

TEST(Simplify, KeepsLockedVerticesAndTheEdgesBetweenThem) {
  SimplifyMesh mesh = rough_ground(30);
  for (std::uint32_t v = 0; v < 31; ++v) mesh.locked[v * 31] = 1;
  Simplifier simplifier;
  simplifier.run(mesh, {.target_triangles = 10, .in_plan = true});
  const std::vector<Triangle> left = remaining(mesh);
  for (std::uint32_t v = 0; v < 31; ++v) EXPECT_EQ(simplifier.parents()[v * 31], v * 31);
  for (std::uint32_t v = 0; v + 1 < 31; ++v) {
    const std::uint32_t a = v * 31, b = (v + 1) * 31;
    EXPECT_EQ(std::count_if(left.begin(), left.end(),
                            [&](const Triangle& t) {
                              return std::count(t.begin(), t.end(), a) == 1 &&
                                     std::count(t.begin(), t.end(), b) == 1;
                            }),
              1);
  }
}

TEST(Simplify, StaysOnAPlaneAndOnItsOutline) {
  SimplifyMesh mesh =
      block_of(test::height_mesh(0, 0, 32, 1, [](double x, double y) { return x + 2 * y; }));
  Simplifier simplifier;
  simplifier.run(mesh, {.target_triangles = 8, .in_plan = true});
  double area = 0;
  for (const Triangle& t : remaining(mesh)) area += 0.5 * double{plan_area(mesh, t)};
  EXPECT_EQ(area, 32.0 * 32 * 64 * 64);
  EXPECT_LE(remaining(mesh).size(), 64u);
}

TEST(Simplify, StopsAtItsErrorBound) {
  SimplifyMesh mesh = rough_ground(40);
  const std::size_t before = mesh.triangles.size();
  Simplifier simplifier;
  simplifier.run(mesh, {.in_plan = true, .max_error = 0.01f});
  EXPECT_GT(simplifier.triangle_count(), before * 9 / 10);
}

TEST(Simplify, LetsColoursSteerWhereAsked) {
  SimplifyMesh mesh = block_of(test::height_mesh(0, 0, 40, 1, [](double, double) { return 0.0; }));
  for (const Vec3f& p : mesh.positions) {
    mesh.further.push_back({p.x > 20.5f * 64 ? 500.0f : 0.0f, 0, 0});
  }
  Simplifier simplifier;
  simplifier.run(mesh, {.target_triangles = mesh.triangles.size() / 8, .in_plan = true});
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_EQ(mesh.further[v], mesh.further[simplifier.parents()[v]]);
  }
}

TEST(Simplify, SurvivesWhatIsNoManifold) {
  SimplifyMesh mesh = rough_ground(12);
  const auto corner = static_cast<std::uint32_t>(mesh.positions.size());
  for (const float x : {0.0f, 100.0f, 200.0f}) mesh.positions.push_back({x, 50, 400});
  mesh.positions.push_back({7, 7, 7});  // without a triangle
  mesh.locked.assign(mesh.positions.size(), 0);
  mesh.triangles.push_back({0, 1, corner});          // a third triangle at an edge
  mesh.triangles.push_back({40, 41, corner + 1});    // and one more
  mesh.triangles.push_back({40, corner + 2, 80});    // a fan of its own
  mesh.triangles.push_back(mesh.triangles.front());  // twice
  Simplifier simplifier;
  simplifier.run(mesh, {.target_triangles = 20});
  EXPECT_LT(simplifier.triangle_count(), mesh.triangles.size() / 2);
  for (const Triangle& t : remaining(mesh)) {
    for (const std::uint32_t v : t) EXPECT_EQ(simplifier.parents()[v], v);
  }
}

/// Few vertices, so that edges and whole triangles come twice and fans branch, loop and meet.
TEST(Simplify, SurvivesAnyTriangles) {
  Simplifier simplifier;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    CounterRandom random(11, 1, seed);
    const auto below = [&](double n) { return static_cast<std::uint32_t>(n * random.uniform()); };
    SimplifyMesh mesh;
    const std::uint32_t vertex_count = 4 + below(12);
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
      mesh.positions.push_back({100.0f * static_cast<float>(random.uniform()),
                                100.0f * static_cast<float>(random.uniform()),
                                10.0f * static_cast<float>(random.uniform())});
      mesh.locked.push_back(random.uniform() < 0.1 ? 1 : 0);
    }
    const std::uint32_t triangle_count = 1 + below(3.0 * vertex_count);
    while (mesh.triangles.size() < triangle_count) {
      const Triangle t{below(vertex_count), below(vertex_count), below(vertex_count)};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
    }
    simplifier.run(mesh, {});
    const std::vector<Triangle> left = remaining(mesh);
    ASSERT_EQ(left.size(), simplifier.triangle_count()) << "seed " << seed;
    for (const Triangle& t : left) {
      for (const std::uint32_t v : t) ASSERT_EQ(simplifier.parents()[v], v) << "seed " << seed;
      ASSERT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) << "seed " << seed;
    }
  }
}

/// The fan of vertex 0 begins at vertex 1 and comes back to vertex 2, which it has passed.
TEST(Simplify, KeepsAVertexWhoseFanEndsInALoop) {
  SimplifyMesh mesh;
  mesh.positions = {{0, 0, 0}, {100, 0, 0}, {50, 90, 0}, {-60, 80, 0}, {-90, 10, 0}};
  mesh.locked.assign(mesh.positions.size(), 0);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 2}};
  Simplifier simplifier;
  simplifier.run(mesh, {});
  EXPECT_EQ(simplifier.parents()[0], 0u);
  EXPECT_FALSE(simplifier.is_border(0));
}

TEST(Simplify, LeavesNothingWithoutTriangles) {
  SimplifyMesh mesh = block_of(test::height_mesh(0, 0, 1, 1, [](double, double) { return 0.0; }));
  Simplifier simplifier;
  simplifier.run(mesh, {});
  EXPECT_EQ(simplifier.triangle_count(), 1u + (simplifier.triangle_count() == 2));
  SimplifyMesh none;
  simplifier.run(none, {});
  EXPECT_EQ(simplifier.triangle_count(), 0u);
}

/// Largest distance from dense samples of one surface to another.
double sampled_distance(const std::vector<Vec3f>& positions, const std::vector<Triangle>& from,
                        const std::vector<Triangle>& to) {
  const TriangleTree tree(positions, to, 1);
  double largest = 0;
  constexpr int kSteps = 6;
  for (const Triangle& t : from) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const float u = static_cast<float>(i) / kSteps, v = static_cast<float>(j) / kSteps;
        const Vec3f p = (1 - u - v) * positions[t[0]] + u * positions[t[1]] + v * positions[t[2]];
        largest = std::max(largest, std::sqrt(double{tree.nearest(p).distance_sq}));
      }
    }
  }
  return largest;
}

/// Ground of hills and gullies with boulders of all sizes, some of them steeper than they are wide.
SimplifyMesh wild_ground(std::uint64_t seed, double roughness) {
  return block_of(test::height_mesh(0, 0, 24, 1, [=](double x, double y) {
    const auto key = static_cast<std::uint64_t>(x * 977 + y);
    const double u = CounterRandom(seed, 1, key).uniform();
    return 3 * std::sin(x / 5) * std::cos(y / 4) + roughness * u * u * u;
  }));
}

std::vector<Float4> fine_positions(const SimplifyMesh& mesh) {
  std::vector<Float4> fine;
  for (const Vec3f& p : mesh.positions) fine.push_back(Float4{p.x, p.y, p.z, 0});
  return fine;
}

std::vector<SimplifyMesh> surfaces_of_many_kinds() {
  std::vector<SimplifyMesh> meshes{
      rough_ground(50), block_of(test::overhang_mesh(40, 30, 4, 0.8)),
      block_of(test::sphere_mesh(20, 4)),
      block_of(test::height_mesh(0, 0, 50, 1, [](double x, double) { return x > 25 ? 30 : 0; }))};
  for (int i = 1; i <= 10; ++i) {
    meshes.push_back(wild_ground(static_cast<std::uint64_t>(i), 0.6 * i));
  }
  return meshes;
}

TEST(StepError, BoundsTheDistanceBothWaysAndClosely) {
  const std::vector<SimplifyMesh> meshes = surfaces_of_many_kinds();
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const SimplifyMesh& input = meshes[i];
    SimplifyMesh mesh = input;
    Simplifier simplifier;
    simplifier.run(mesh, {.target_triangles = mesh.triangles.size() / (i % 2 == 0 ? 4 : 16)});
    const std::vector<Float4> fine = fine_positions(input);
    StepError error;
    error.prepare(simplifier, fine, input.triangles);
    const double bound = error.of(0, input.triangles.size());
    const std::vector<Triangle> left = remaining(mesh);
    const double sampled = std::max(sampled_distance(input.positions, input.triangles, left),
                                    sampled_distance(input.positions, left, input.triangles));
    // Units are 1/64; floats of a few thousand units are exact to a hundredth.
    EXPECT_GE(bound + 0.02, sampled) << "mesh " << i;
    EXPECT_LE(bound, 2.2 * sampled + 1) << "mesh " << i;
  }
}

/// Round such a vertex lie more triangles than links in order can name.
TEST(StepError, IsNothingWhereAVertexOfManyTrianglesStays) {
  constexpr std::uint32_t kRim = 40;
  SimplifyMesh mesh;
  for (std::uint32_t i = 0; i < kRim; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRim;
    mesh.positions.push_back({static_cast<float>(std::round(900 * std::cos(angle))),
                              static_cast<float>(std::round(900 * std::sin(angle))), 0});
    mesh.triangles.push_back({i, (i + 1) % kRim, kRim});
  }
  mesh.positions.push_back({0, 0, 0});
  mesh.locked.assign(mesh.positions.size(), 1);
  const SimplifyMesh input = mesh;
  Simplifier simplifier;
  simplifier.run(mesh, {});
  ASSERT_EQ(simplifier.triangle_count(), kRim);
  const std::vector<Float4> fine = fine_positions(input);
  const std::vector<std::uint8_t> shared(mesh.positions.size(), 1);
  StepError error;
  error.prepare(simplifier, fine, input.triangles, shared);
  EXPECT_EQ(error.of(0, input.triangles.size()), 0.0f);
}

/// A range of triangles has the edges of its own triangles, whichever way round they are named.
TEST(StepError, IsTheLargestOfItsPartsHoweverCut) {
  for (const std::uint64_t seed : {5u, 6u, 7u}) {
    const SimplifyMesh input = wild_ground(seed, 3);
    SimplifyMesh mesh = input;
    Simplifier simplifier;
    simplifier.run(mesh, {.target_triangles = mesh.triangles.size() / 4});
    const std::vector<std::uint8_t> shared(mesh.positions.size(), 1);
    const std::vector<Float4> fine = fine_positions(input);
    StepError error;
    error.prepare(simplifier, fine, input.triangles, shared);
    const float whole = error.of(0, input.triangles.size());
    float largest = 0;
    for (std::size_t t = 0; t < input.triangles.size(); t += 7) {
      largest = std::max(largest, error.of(t, std::min(t + 7, input.triangles.size())));
    }
    EXPECT_FLOAT_EQ(largest, whole);
    error.begin_part();
    for (std::size_t t = 0; t < input.triangles.size(); t += 7) {
      error.add(t, std::min(t + 7, input.triangles.size()));
    }
    EXPECT_EQ(whole, error.end_part());
    error.prepare(simplifier, fine, input.triangles, shared);
    EXPECT_EQ(whole, error.of(0, input.triangles.size()));
  }
}

TEST(PositionFilter, CallsNoPointAloneThatItHasTwiceAndMostOthers) {
  PositionFilter filter;
  constexpr std::int32_t kCount = 2000;
  const auto point = [](std::int32_t i) { return LatticePoint{i, 7 * i, -i / 3}; };
  filter.reset(kCount);
  for (std::int32_t i = 0; i < kCount; ++i) filter.add(point(i));
  for (std::int32_t i = 0; i < kCount; i += 10) filter.add(point(i));
  int alone = 0;
  for (std::int32_t i = 0; i < kCount; ++i) {
    const bool is_alone = filter.is_alone(point(i));
    EXPECT_FALSE(is_alone && i % 10 == 0) << i;
    alone += is_alone;
  }
  EXPECT_GT(alone, kCount * 7 / 10);
}

TEST(Octahedral, DecodesEightAtATimeAsOneByOne) {
  for (const int bits : {8, 10}) {
    const int limit = octahedral_limit(bits);
    for (int i = -limit; i <= limit; ++i) {
      NormalLanes lanes;
      for (std::size_t k = 0; k < NormalLanes::kCount; ++k) {
        lanes.i[k] = i, lanes.j[k] = static_cast<int>(k) * limit / 4 - limit;
      }
      decode_octahedral(lanes, bits);
      for (std::size_t k = 0; k < NormalLanes::kCount; ++k) {
        const Vec3f n = decode_octahedral(
            {static_cast<std::int16_t>(i), static_cast<std::int16_t>(lanes.j[k])}, bits);
        EXPECT_EQ(n, (Vec3f{lanes.x[k], lanes.y[k], lanes.z[k]})) << i << " " << lanes.j[k];
      }
    }
  }
}

}  // namespace
}  // namespace cornice::hlod
