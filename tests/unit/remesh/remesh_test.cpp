// SPDX-License-Identifier: GPL-3.0-or-later
// Remeshing against known surfaces; distances by CGAL's tree, a second opinion on ours.
#include "stages/remesh/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/mesh/select.h"
#include "core/mesh/surface_distance.h"
#include "core/mesh/topology.h"
#include "tests/support/meshes.h"
#include "tests/support/solids.h"

namespace cornice::remesh {
namespace {

/// Largest distance of points of `from`, about spacing_m apart, from `to`.
double distance_by_cgal(const Mesh& from, const Mesh& to, float spacing_m) {
  test::Solids all = test::solids(to);
  const test::SolidTree tree(all.begin(), all.end());
  double worst = 0.0;
  for (const Triangle& t : from.triangles) {
    std::vector<Vec3f> samples{from.positions[t[0]], from.positions[t[1]], from.positions[t[2]]};
    sample_triangle(samples[0], samples[1], samples[2], spacing_m, samples);
    for (const Vec3f p : samples)
      worst = std::max(worst, tree.squared_distance(test::solid_point(p)));
  }
  return std::sqrt(worst);
}

double hills(double x, double y) {
  return 6.0 * std::sin(x / 9.0) * std::cos(y / 11.0) + 1.2 * std::sin(x / 2.5 + y / 3.0);
}

Mesh rough_hills(int cells) {
  Mesh mesh = test::height_mesh(0, 0, cells, 0.5, [](double x, double y) {
    return hills(x, y) + 0.005 * CounterRandom(3, static_cast<std::uint64_t>(2 * x),
                                               static_cast<std::uint64_t>(2 * y))
                                     .normal();
  });
  mesh.origin = {2600000, 1200000, 1000};
  mesh.crs_text = "EPSG:2056";
  FloatProperty support{"support", {}};
  ByteProperty bridged{"bridged", {}};
  for (const Vec3f p : mesh.positions) {
    support.values.push_back(0.01f * p.x);
    bridged.values.push_back(p.x > 20.0f);
    mesh.normals.push_back({0, 0, 1});
  }
  mesh.float_properties.push_back(support);
  mesh.byte_properties.push_back(bridged);
  return mesh;
}

void expect_within(const Mesh& input, const Result& result, double bound) {
  EXPECT_LE(result.figures.hausdorff_m(), bound);
  EXPECT_LE(distance_by_cgal(input, result.mesh, 0.12f), bound);
  EXPECT_LE(distance_by_cgal(result.mesh, input, 0.12f), bound);
}

TEST(Remesh, MakesFewWellShapedTrianglesWithinTheBound) {
  const Mesh mesh = rough_hills(110);
  const Result result = remesh(mesh, {});
  expect_within(mesh, result, 0.05);
  EXPECT_LT(result.mesh.triangles.size(), mesh.triangles.size() / 2);
  EXPECT_GE(result.figures.quality.share_min_angle_20(), 0.99);
  EXPECT_EQ(measure_quality(result.mesh.positions, result.mesh.triangles, 1).below_20_deg,
            result.figures.quality.below_20_deg);
  EXPECT_TRUE(check_topology(result.mesh.triangles, result.mesh.positions.size(), 1).is_manifold());
  // No fold: the ground is a graph, so every triangle looks up.
  for (const Triangle& t : result.mesh.triangles) {
    const Vec3f a = result.mesh.positions[t[0]];
    EXPECT_GT(cross(result.mesh.positions[t[1]] - a, result.mesh.positions[t[2]] - a).z, 0.0f);
  }
}

TEST(Remesh, KeepsBordersBitForBitWithTheirAttributes) {
  Mesh mesh = rough_hills(80);
  // A hole, whose rim is a border, too.
  std::vector<std::uint8_t> keep;
  for (const Triangle& t : mesh.triangles) {
    const Vec3f p = mesh.positions[t[0]];
    keep.push_back(std::hypot(p.x - 25, p.y - 25) > 6);
  }
  mesh = select_triangles(mesh, keep);
  const Result result = remesh(mesh, {});
  EXPECT_EQ(test::border_edges(result.mesh), test::border_edges(mesh));
  EXPECT_EQ(result.mesh.origin, mesh.origin);
  EXPECT_EQ(result.mesh.crs_text, mesh.crs_text);
  const auto& support = *find_float_property(result.mesh, "support");
  const auto& bridged = *find_byte_property(result.mesh, "bridged");
  for (std::size_t v = 0; v < result.mesh.positions.size(); ++v) {
    EXPECT_NEAR(support[v], 0.01f * result.mesh.positions[v].x, 2e-3f);
    EXPECT_NEAR(norm(result.mesh.normals[v]), 1.0f, 1e-5f);
    if (std::abs(result.mesh.positions[v].x - 20.0f) > 1.0f) {
      EXPECT_EQ(bridged[v], result.mesh.positions[v].x > 20.0f);
    }
  }
}

TEST(Remesh, GivesTheSameBytesWithAnyNumberOfThreads) {
  const Mesh mesh = rough_hills(170);
  Options options;
  options.threads = 1;
  const Result one = remesh(mesh, options);
  options.threads = 2;
  const Result two = remesh(mesh, options);
  EXPECT_EQ(one.mesh.positions, two.mesh.positions);
  EXPECT_EQ(one.mesh.triangles, two.mesh.triangles);
  EXPECT_EQ(one.mesh.float_properties[0].values, two.mesh.float_properties[0].values);
  EXPECT_EQ(one.figures.hausdorff_m(), two.figures.hausdorff_m());
}

TEST(Remesh, KeepsASphereClosedAndRound) {
  const Mesh sphere = test::sphere_mesh(12.0, 5);
  const Result result = remesh(sphere, {});
  expect_within(sphere, result, 0.05);
  const auto report = check_topology(result.mesh.triangles, result.mesh.positions.size(), 1);
  EXPECT_TRUE(report.is_manifold());
  EXPECT_EQ(report.open_edges, 0u);
  EXPECT_EQ(report.components, 1u);
  const auto v = static_cast<std::int64_t>(result.mesh.positions.size());
  const auto f = static_cast<std::int64_t>(result.mesh.triangles.size());
  EXPECT_EQ(v - f / 2, 2);  // Euler: still a sphere
  EXPECT_LT(result.mesh.triangles.size(), sphere.triangles.size() / 4);
}

TEST(Remesh, KeepsAnOverhang) {
  const Mesh mesh = test::overhang_mesh(60, 40, 6, 0.4);
  const Result result = remesh(mesh, {});
  expect_within(mesh, result, 0.05);
  EXPECT_TRUE(check_topology(result.mesh.triangles, result.mesh.positions.size(), 1).is_manifold());
  const auto underside = [](const Mesh& m) {
    double area = 0.0;
    for (const Triangle& t : m.triangles) {
      const Vec3f a = m.positions[t[0]];
      const Vec3f n = cross(m.positions[t[1]] - a, m.positions[t[2]] - a);
      if (n.z < 0.0f) area += 0.5 * static_cast<double>(norm(n));
    }
    return area;
  };
  EXPECT_GT(underside(mesh), 50.0);
  EXPECT_NEAR(underside(result.mesh), underside(mesh), 0.02 * underside(mesh));
}

TEST(Remesh, KeepsASteepWall) {
  const Mesh mesh = test::height_mesh(0, 0, 60, 0.5, [](double x, double y) {
    return 4.0 * std::tanh((x + 0.3 * y - 20.0) / 1.5);
  });
  expect_within(mesh, remesh(mesh, {}), 0.05);
}

TEST(Remesh, KeepsTrianglesRoundWhereRoughGroundNeedsMending) {
  const Mesh mesh = test::height_mesh(0, 0, 60, 0.5, [](double x, double y) {
    return hills(x, y) + 0.02 * CounterRandom(5, static_cast<std::uint64_t>(2 * x),
                                              static_cast<std::uint64_t>(2 * y))
                                    .normal();
  });
  const Result result = remesh(mesh, {});
  EXPECT_GE(result.figures.repair_rounds, 1);
  EXPECT_GE(result.figures.inner_quality.share_min_angle_20(), 0.995);
  EXPECT_LE(distance_by_cgal(mesh, result.mesh, 0.12f), 0.05);
  EXPECT_LE(distance_by_cgal(result.mesh, mesh, 0.12f), 0.05);
}

/// Moves vertices of a mesh over the plane along it, and onto the ground there.
void put(Mesh& mesh, std::uint32_t vertex, float x, float y) {
  mesh.positions[vertex] = Vec3d{x, y, hills(x, y)}.cast<float>();
}

std::size_t triangles_shorter_than(const Mesh& mesh, float length) {
  return static_cast<std::size_t>(
      std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
        const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
        return std::max({norm(b - a), norm(c - b), norm(a - c)}) < length;
      }));
}

/// A reconstruction puts three or four vertices beside a node of its lattice that the surface
/// almost goes through. They must not be taken for detail.
TEST(Remesh, SeesThroughHeapsOfVertices) {
  constexpr int kCells = 60;
  const Mesh even = test::height_mesh(0, 0, kCells, 0.5, hills);
  Mesh mesh = even;
  std::size_t heaps = 0;
  for (std::uint32_t row = 5; row < kCells - 5; row += 6) {
    for (std::uint32_t column = 5; column < kCells - 5; column += 6, ++heaps) {
      const std::uint32_t v = row * (kCells + 1) + column;
      const float x = 0.5f * static_cast<float>(column) + 0.25f;
      const float y = 0.5f * static_cast<float>(row) + 0.25f;
      put(mesh, v, x - 0.0015f, y - 0.002f);
      put(mesh, v + 1, x + 0.0025f, y - 0.0015f);
      put(mesh, v + kCells + 1, x - 0.0025f, y + 0.0015f);
      put(mesh, v + kCells + 2, x + 0.002f, y + 0.0025f);
    }
  }
  ASSERT_EQ(heaps, 81u);
  ASSERT_EQ(triangles_shorter_than(mesh, 0.1f), 2 * heaps);
  const Result result = remesh(mesh, {});
  expect_within(mesh, result, 0.05);
  EXPECT_LE(result.mesh.triangles.size(), remesh(even, {}).mesh.triangles.size());
}

/// Vertices of a border stay where they are, but what is small there must not spread.
TEST(Remesh, SurroundsAHeapOnTheBorderByFewTriangles) {
  constexpr int kCells = 60;
  Mesh mesh = test::height_mesh(0, 0, kCells, 0.5, hills);
  for (std::uint32_t column = 10; column < kCells - 5; column += 10) {
    const float x = 0.5f * static_cast<float>(column);
    put(mesh, column - 1, x - 0.003f, 0.0f);
    put(mesh, column + 1, x + 0.002f, 0.0f);
  }
  const Result result = remesh(mesh, {});
  EXPECT_EQ(test::border_edges(result.mesh), test::border_edges(mesh));
  expect_within(mesh, result, 0.05);
  EXPECT_LE(triangles_shorter_than(result.mesh, 0.25f), 20u);
}

TEST(Remesh, MendsShapesWhereOneTriangleInAThousandIsThin) {
  const Mesh mesh = test::height_mesh(0, 0, 110, 0.5, [](double x, double y) {
    return hills(x, y) + 0.02 * CounterRandom(5, static_cast<std::uint64_t>(2 * x),
                                              static_cast<std::uint64_t>(2 * y))
                                    .normal();
  });
  const Result result = remesh(mesh, {});
  EXPECT_GT(result.mesh.triangles.size(), 5000u);
  EXPECT_LE(result.figures.inner_quality.below_20_deg, 1u);
}

TEST(Remesh, TakesDegenerateInput) {
  EXPECT_TRUE(remesh({}, {}).mesh.triangles.empty());
  Mesh one;
  one.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  EXPECT_EQ(remesh(one, {}).mesh.triangles.size(), 1u);
  one.triangles = {{0, 1, 2}, {1, 2, 0}, {0, 0, 1}};
  const Result result = remesh(one, {});
  EXPECT_EQ(result.mesh.triangles.size(), 1u);
  EXPECT_EQ(result.figures.dropped_triangles, 2u);
  one.triangles = {{0, 0, 1}};
  EXPECT_TRUE(remesh(one, {}).mesh.triangles.empty());
}

TEST(Remesh, LeavesVerticesWhereTheInputIsNoManifold) {
  Mesh mesh = rough_hills(40);
  // A fin on an inner edge: three triangles at one edge.
  const Triangle t = mesh.triangles[mesh.triangles.size() / 2];
  mesh.positions.push_back(mesh.positions[t[0]] + Vec3f{0, 0, 2});
  mesh.normals.push_back({0, 0, 1});
  mesh.float_properties[0].values.push_back(0);
  mesh.byte_properties[0].values.push_back(0);
  mesh.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(mesh.positions.size() - 1)});
  const Result result = remesh(mesh, {});
  EXPECT_GT(result.figures.bad_input_edges, 0u);
  expect_within(mesh, result, 0.05);
  EXPECT_LE(
      check_topology(result.mesh.triangles, result.mesh.positions.size(), 1).non_manifold_edges,
      check_topology(mesh.triangles, mesh.positions.size(), 1).non_manifold_edges);
}

}  // namespace
}  // namespace cornice::remesh
