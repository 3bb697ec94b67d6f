// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/grid_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/random.h"
#include "core/mesh/topology.h"

namespace cornice::dem {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

/// A piece of width x height own pixels at (0, 0); heights by column and row of the whole survey.
HeightWindow window_of(std::int64_t width, std::int64_t height,
                       const std::function<float(std::int64_t col, std::int64_t row)>& z) {
  HeightWindow window;
  window.own = {0, 0, width, height};
  const PixelRect rect = HeightWindow::rect_for(window.own);
  for (std::int64_t row = rect.row; row < rect.end_row(); ++row) {
    for (std::int64_t col = rect.col; col < rect.end_col(); ++col) {
      window.heights.push_back(z(col, row));
    }
  }
  return window;
}

/// The same without neighbours: only own pixels have heights.
HeightWindow lonely_window(std::int64_t width, std::int64_t height,
                           const std::function<float(std::int64_t col, std::int64_t row)>& z) {
  return window_of(width, height, [&](std::int64_t col, std::int64_t row) {
    return col >= 0 && row >= 0 && col < width && row < height ? z(col, row) : kNothing;
  });
}

VertexPlaces places_for(const HeightWindow& window) {
  VertexPlaces places;
  for (std::int64_t i = 0; i <= window.own.width; ++i) {
    places.east.push_back(static_cast<float>(i));
  }
  for (std::int64_t i = 0; i <= window.own.height; ++i) {
    places.north.push_back(static_cast<float>(window.own.height - i));
  }
  return places;
}

Mesh mesh_of(const HeightWindow& window, int threads = 1) {
  return whole_mesh(GridSurface(window, threads), places_for(window), threads);
}

void expect_upward(const Mesh& mesh) {
  for (const auto& t : mesh.triangles) {
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    ASSERT_GT(cross(b - a, c - a).z, 0.0f);
  }
}

TopologyReport topology_of(const Mesh& mesh) {
  return check_topology(mesh.triangles, mesh.positions.size(), 1);
}

float plane(std::int64_t col, std::int64_t row) {
  return 100.0f + 0.5f * static_cast<float>(col) - 0.25f * static_cast<float>(row);
}

TEST(GridSurface, WithoutNeighboursEndsAtTheLastPixelsCentres) {
  const Mesh mesh = mesh_of(lonely_window(4, 3, plane));
  EXPECT_EQ(mesh.positions.size(), 12u);
  EXPECT_EQ(mesh.triangles.size(), 2u * 3u * 2u);
  expect_upward(mesh);
  EXPECT_TRUE(topology_of(mesh).is_manifold());
  EXPECT_EQ(topology_of(mesh).open_edges, 2u * (3u + 2u));
}

TEST(GridSurface, TakesTheNeighboursFirstRowColumnAndCorner) {
  const Mesh mesh = mesh_of(window_of(4, 3, plane));
  EXPECT_EQ(mesh.positions.size(), 5u * 4u);
  EXPECT_EQ(mesh.triangles.size(), 2u * 4u * 3u);
  // The corner of the upper right neighbour: column 4, row -1.
  EXPECT_EQ(mesh.positions[4], (Vec3f{4.0f, 3.0f, plane(4, -1)}));
}

TEST(GridSurface, MeshesOnlyTheBorderThatANeighbourHas) {
  // To the right there is a tile, above there is none.
  const Mesh mesh = mesh_of(window_of(4, 3, [](std::int64_t col, std::int64_t row) {
    return row < 0 ? kNothing : plane(col, row);
  }));
  EXPECT_EQ(mesh.triangles.size(), 2u * 4u * 2u);
  EXPECT_EQ(topology_of(mesh).isolated_vertices, 0u);
}

TEST(GridSurface, OnePixelWithoutDataLeavesAHoleOfFourEdges) {
  const Mesh mesh = mesh_of(lonely_window(5, 5, [](std::int64_t col, std::int64_t row) {
    return col == 2 && row == 2 ? kNothing : plane(col, row);
  }));
  EXPECT_EQ(mesh.positions.size(), 24u);
  // Twelve whole cells; the four around the pixel keep the corner that leans on whole ones.
  EXPECT_EQ(mesh.triangles.size(), 2u * 12u + 4u);
  const TopologyReport report = topology_of(mesh);
  EXPECT_TRUE(report.is_manifold());
  EXPECT_EQ(report.open_edges, 16u + 4u);
  expect_upward(mesh);
}

TEST(GridSurface, ACellWithThreeHeightsAloneGetsNoTriangle) {
  const Mesh mesh = mesh_of(lonely_window(2, 2, [](std::int64_t col, std::int64_t row) {
    return col == 1 && row == 1 ? kNothing : plane(col, row);
  }));
  EXPECT_TRUE(mesh.triangles.empty());
  EXPECT_TRUE(mesh.positions.empty());
}

TEST(GridSurface, WholeCellsThatTouchInACornerAreJoined) {
  // Own pixels of the cells lower left and upper right; the two others lack their outer corner.
  const Mesh mesh = mesh_of(lonely_window(3, 3, [](std::int64_t col, std::int64_t row) {
    return (col == 0 && row == 0) || (col == 2 && row == 2) ? kNothing : plane(col, row);
  }));
  EXPECT_EQ(mesh.triangles.size(), 2u * 2u + 2u);
  EXPECT_TRUE(topology_of(mesh).is_manifold());
  EXPECT_EQ(topology_of(mesh).components, 1u);
}

TEST(GridSurface, RandomHolesLeaveAManifoldWithoutDanglingTriangles) {
  std::uint64_t doubled = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const double share = 0.05 + 0.5 * static_cast<double>(seed % 10) / 10.0;
    const HeightWindow window = window_of(17, 13, [&](std::int64_t col, std::int64_t row) {
      CounterRandom random(seed, static_cast<std::uint64_t>(col + 5),
                           static_cast<std::uint64_t>(row + 5));
      return random.uniform() < share ? kNothing : static_cast<float>(random.uniform(0.0, 9.0));
    });
    const GridSurface surface(window, 1);
    doubled += surface.doubled_vertices();
    const Mesh mesh = whole_mesh(surface, places_for(window), 1);
    const TopologyReport report = topology_of(mesh);
    ASSERT_TRUE(report.is_manifold()) << "seed " << seed;
    ASSERT_EQ(report.isolated_vertices, 0u) << "seed " << seed;
    expect_upward(mesh);
  }
  // Rims of holes that run through the border of a piece do occur.
  EXPECT_GT(doubled, 0u);
}

TEST(GridSurface, WithoutNeighboursNothingHasToBeDoubledAndNoTriangleHangsByOneEdge) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const HeightWindow window = lonely_window(20, 20, [&](std::int64_t col, std::int64_t row) {
      CounterRandom random(seed, static_cast<std::uint64_t>(col), static_cast<std::uint64_t>(row));
      return random.uniform() < 0.2 ? kNothing : 1.0f;
    });
    const GridSurface surface(window, 1);
    ASSERT_EQ(surface.doubled_vertices(), 0u);
    const Mesh mesh = whole_mesh(surface, places_for(window), 1);
    const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3f a = mesh.positions[mesh.triangles[t][0]],
                  b = mesh.positions[mesh.triangles[t][1]],
                  c = mesh.positions[mesh.triangles[t][2]];
      int open_legs = 0;
      for (int k = 0; k < 3; ++k) open_legs += twins[3 * t + k] == kOpenEdge;
      // Half of a lone cell has two open edges, and its other half; a corner has one at most.
      const float area = cross(b - a, c - a).z;
      ASSERT_EQ(area, 1.0f);
      ASSERT_LE(open_legs, 2);
    }
  }
}

TEST(GridSurface, DiagonalsFollowARidgeThatCutsTheGridAslant) {
  const auto ridge = [](std::int64_t col, std::int64_t row) {
    return -std::abs(static_cast<float>(col + row) - 20.0f);
  };
  const HeightWindow window = window_of(21, 21, ridge);
  const Mesh mesh = mesh_of(window);
  int on_ridge = 0;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Vec3f a = mesh.positions[t[k]], b = mesh.positions[t[(k + 1) % 3]];
      on_ridge += a.z == 0.0f && b.z == 0.0f && a.x != b.x && a.y != b.y;
    }
  }
  // Col + row = 20 from the lower left to the upper right, each edge seen from both sides.
  EXPECT_EQ(on_ridge, 2 * 21);
}

/// Root mean square of what is missing at the cells' centres.
double error_at_centres(const Mesh& mesh, const std::function<double(double, double)>& truth) {
  double sum = 0.0;
  int count = 0;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Vec3f a = mesh.positions[t[k]], b = mesh.positions[t[(k + 1) % 3]];
      if (a.x == b.x || a.y == b.y) continue;
      const auto x = static_cast<double>(a.x + b.x) / 2, y = static_cast<double>(a.y + b.y) / 2;
      const double z = static_cast<double>(a.z + b.z) / 2 - truth(x, y);
      sum += z * z;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(GridSurface, DiagonalsByCurvatureComeNearerToASmoothSurfaceThanFixedOnes) {
  constexpr std::int64_t kSide = 60;
  // Gullies at an angle; vertex (x, y) is column x, row kSide - 1 - y.
  const auto truth = [](double x, double y) {
    return 30.0 * std::sin(0.31 * x + 0.17 * y) + 20.0 * std::sin(0.23 * x - 0.4 * y);
  };
  const HeightWindow window = window_of(kSide, kSide, [&](std::int64_t col, std::int64_t row) {
    return static_cast<float>(
        truth(static_cast<double>(col), static_cast<double>(kSide - 1 - row)));
  });
  const double ours = error_at_centres(mesh_of(window), truth);
  double fixed = 0.0, best = 0.0;
  for (std::int64_t row = 0; row < kSide; ++row) {
    for (std::int64_t col = 0; col < kSide; ++col) {
      // The cell's lower left vertex.
      const auto x = static_cast<double>(col), y = static_cast<double>(kSide - 1 - row);
      const double centre = truth(x + 0.5, y + 0.5);
      const double rising = 0.5 * (truth(x, y) + truth(x + 1, y + 1)) - centre;
      const double falling = 0.5 * (truth(x + 1, y) + truth(x, y + 1)) - centre;
      fixed += rising * rising;
      best += std::min(rising * rising, falling * falling);
    }
  }
  EXPECT_LT(ours, 0.85 * std::sqrt(fixed / (kSide * kSide)));
  EXPECT_LT(ours, 1.01 * std::sqrt(best / (kSide * kSide)));
}

TEST(GridSurface, NormalsOfAQuadricAreItsOwn) {
  const auto quadric = [](std::int64_t col, std::int64_t row) {
    const auto x = static_cast<float>(col), y = static_cast<float>(4 - row);
    return 0.25f * x * x + 0.5f * x * y - 0.125f * y * y;
  };
  const Mesh mesh = mesh_of(window_of(6, 5, quadric));
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double x = mesh.positions[v].x, y = mesh.positions[v].y;
    const Vec3d truth = normalized(Vec3d{-(0.5 * x + 0.5 * y), -(0.5 * x - 0.25 * y), 1.0});
    EXPECT_LT(norm(mesh.normals[v].cast<double>() - truth), 1e-6);
  }
}

TEST(GridSurface, NormalsBesideAHoleAreUnitVectors) {
  const Mesh mesh = mesh_of(lonely_window(5, 5, [](std::int64_t col, std::int64_t row) {
    return col == 2 && row == 2 ? kNothing : static_cast<float>(3 * col * col + row);
  }));
  for (const Vec3f& n : mesh.normals) {
    EXPECT_NEAR(norm(n), 1.0f, 1e-6f);
    EXPECT_GT(n.z, 0.0f);
  }
}

TEST(GridSurface, CellsThatAnotherTileHasAreLeftToIt) {
  HeightWindow window = window_of(6, 6, plane);
  window.taken = {{0, 0, 2, 6}};
  const Mesh mesh = mesh_of(window);
  EXPECT_EQ(mesh.triangles.size(), 2u * 4u * 6u);
  EXPECT_EQ(topology_of(mesh).isolated_vertices, 0u);
}

}  // namespace
}  // namespace cornice::dem
