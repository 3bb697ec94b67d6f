// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/topology.h"

#include <gtest/gtest.h>

#include "core/mesh/select.h"
#include "tests/support/meshes.h"

namespace cornice {
namespace {

Mesh flat(int cells) {
  return test::height_mesh(0, 0, cells, 1.0, [](double, double) { return 0.0; });
}

TEST(MatchHalfEdges, PairsEveryInnerEdgeOfAGridAndLeavesItsRimOpen) {
  const Mesh mesh = flat(5);
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 2);
  std::size_t open = 0;
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    if (twins[h] == kOpenEdge) {
      ++open;
      continue;
    }
    ASSERT_LT(twins[h], kNoTwin);
    EXPECT_EQ(twins[twins[h]], h);
    const auto& t = mesh.triangles;
    EXPECT_EQ(t[h / 3][h % 3], t[twins[h] / 3][(twins[h] % 3 + 1) % 3]);
  }
  EXPECT_EQ(open, 20u);
  EXPECT_EQ(twins, match_half_edges(mesh.triangles, mesh.positions.size(), 1));
}

TEST(CheckTopology, FindsNothingWrongWithASphere) {
  const Mesh mesh = test::sphere_mesh(1.0, 3);
  const TopologyReport report = check_topology(mesh.triangles, mesh.positions.size(), 2);
  EXPECT_TRUE(report.is_manifold());
  EXPECT_EQ(report.open_edges, 0u);
  EXPECT_EQ(report.components, 1u);
  EXPECT_EQ(report.isolated_vertices, 0u);
}

TEST(CheckTopology, CountsAThirdTriangleOnAnEdge) {
  Mesh mesh = flat(1);
  mesh.positions.push_back({0.5f, 0.5f, 1.0f});
  mesh.triangles.push_back({3, 0, 4});
  const TopologyReport report = check_topology(mesh.triangles, 5, 1);
  EXPECT_EQ(report.non_manifold_edges, 1u);
  EXPECT_FALSE(report.is_manifold());
}

TEST(CheckTopology, CountsTwoTrianglesThatRunAlongAnEdgeTheSameWay) {
  const std::vector<Triangle> triangles{{0, 1, 2}, {0, 1, 3}};
  EXPECT_EQ(check_topology(triangles, 4, 1).non_manifold_edges, 1u);
}

TEST(CheckTopology, CountsAVertexWhereTwoFansTouch) {
  const std::vector<Triangle> triangles{{0, 1, 2}, {0, 3, 4}};
  const TopologyReport report = check_topology(triangles, 6, 1);
  EXPECT_EQ(report.non_manifold_vertices, 1u);
  EXPECT_EQ(report.isolated_vertices, 1u);
  EXPECT_EQ(report.components, 2u);
}

TEST(CheckTopology, CountsDuplicateAndDegenerateTriangles) {
  const std::vector<Triangle> triangles{{0, 1, 2}, {1, 2, 0}, {0, 0, 1}};
  const TopologyReport report = check_topology(triangles, 3, 1);
  EXPECT_EQ(report.duplicate_triangles, 1u);
  EXPECT_EQ(report.degenerate_triangles, 1u);
}

TEST(CheckTopology, TakesAnEmptyMesh) {
  const TopologyReport report = check_topology({}, 0, 1);
  EXPECT_TRUE(report.is_manifold());
  EXPECT_EQ(report.components, 0u);
}

TEST(BorderLoops, GoRoundARimWithTheSurfaceToTheLeft) {
  Mesh mesh = flat(4);
  // A hole in the middle: the two triangles of one cell.
  std::vector<std::uint8_t> keep(mesh.triangles.size(), 1);
  keep[2 * 5] = keep[2 * 5 + 1] = 0;
  mesh = select_triangles(mesh, keep);
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 1);
  const auto loops = border_loops(mesh.triangles, twins, mesh.positions.size());
  ASSERT_EQ(loops.size(), 2u);
  for (const auto& loop : loops) {
    double area2 = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec3f a = mesh.positions[loop[i]], b = mesh.positions[loop[(i + 1) % loop.size()]];
      area2 += static_cast<double>(a.x * b.y - b.x * a.y);
    }
    EXPECT_DOUBLE_EQ(area2, loop.size() == 16 ? 32.0 : -2.0);
  }
}

TEST(SelectTriangles, CarriesAttributesOfTheVerticesThatStay) {
  Mesh mesh = flat(2);
  FloatProperty support{"support", {}};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    support.values.push_back(static_cast<float>(v));
  }
  mesh.float_properties.push_back(support);
  std::vector<std::uint8_t> keep(mesh.triangles.size(), 0);
  keep.back() = 1;
  std::vector<std::uint32_t> rows;
  const Mesh part = select_triangles(mesh, keep, &rows);
  ASSERT_EQ(part.triangles.size(), 1u);
  EXPECT_EQ(rows, (std::vector<std::uint32_t>{4, 7, 8}));
  EXPECT_EQ(part.float_properties[0].values, (std::vector<float>{4, 7, 8}));
  EXPECT_EQ(part.positions[part.triangles[0][0]], mesh.positions[mesh.triangles.back()[0]]);
}

}  // namespace
}  // namespace cornice
