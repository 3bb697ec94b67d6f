// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/trim/trim.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/select.h"
#include "core/mesh/topology.h"
#include "stages/trim/point_support.h"
#include "tests/support/meshes.h"

namespace cornice::trim {
namespace {

constexpr float kFarAway = 50.0f;

/// Ground of 40 m x 40 m from (x, y), measured where `measured` says so.
template <class F>
Mesh ground(double x, double y, F&& measured, double step = 0.5) {
  Mesh mesh = test::height_mesh(x, y, static_cast<int>(40.0 / step), step, [](double a, double b) {
    return std::sin(0.3 * a) + std::cos(0.2 * b);
  });
  FloatProperty support{"support", {}};
  for (const Vec3f p : mesh.positions) support.values.push_back(measured(p) ? 0.1f : kFarAway);
  mesh.float_properties.push_back(support);
  return mesh;
}

/// True where the result has a triangle over the place.
bool covers(const Mesh& mesh, float x, float y) {
  const auto side = [&](Vec3f a, Vec3f b) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
  };
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    return side(a, b) >= 0 && side(b, c) >= 0 && side(c, a) >= 0;
  });
}

const std::vector<std::uint8_t>& source(const Mesh& mesh) {
  return *find_byte_property(mesh, "source");
}

TEST(Trim, KeepsMeasuredSurfaceAsItIs) {
  const Mesh mesh = ground(0, 0, [](Vec3f) { return true; });
  const Result result = trim(mesh, {});
  EXPECT_EQ(result.mesh.positions, mesh.positions);
  EXPECT_EQ(result.mesh.triangles, mesh.triangles);
  EXPECT_EQ(std::count(source(result.mesh).begin(), source(result.mesh).end(), 1), 0);
}

TEST(Trim, BridgesARiverNarrowerThanTheBridgeAndMarksIt) {
  const Mesh mesh = ground(0, 0, [](Vec3f p) { return std::abs(p.x - 20) > 4; });
  Options options;
  options.bridge_m = 10.0;
  const Result result = trim(mesh, options);
  EXPECT_EQ(result.mesh.triangles.size(), mesh.triangles.size());
  for (std::size_t v = 0; v < result.mesh.positions.size(); ++v) {
    EXPECT_EQ(source(result.mesh)[v] != 0, std::abs(result.mesh.positions[v].x - 20) <= 4);
  }
  EXPECT_NEAR(result.counts.bridged_area_m2, 40 * 9, 45);
  // Support survives, so that bridged ground can be told from measured ground.
  EXPECT_EQ(*find_float_property(result.mesh, "support"), *find_float_property(mesh, "support"));
}

TEST(Trim, DropsARiverWiderThanTheBridgeAllTheWayToItsBanks) {
  const Mesh mesh = ground(0, 0, [](Vec3f p) { return std::abs(p.x - 20) > 7; });
  Options options;
  options.bridge_m = 10.0;
  const Result result = trim(mesh, options);
  EXPECT_EQ(result.counts.bridged_vertices, 0u);
  EXPECT_FALSE(covers(result.mesh, 14.1f, 20.0f));
  EXPECT_FALSE(covers(result.mesh, 20.1f, 20.0f));
  EXPECT_TRUE(covers(result.mesh, 12.1f, 20.0f));
}

TEST(Trim, DropsWhatLiesOutsideTheMeasuredGroundHoweverNarrow) {
  const Mesh mesh = ground(0, 0, [](Vec3f p) { return p.x < 38 && p.y > 3; });
  const Result result = trim(mesh, {});
  EXPECT_EQ(result.counts.bridged_vertices, 0u);
  for (const Vec3f p : result.mesh.positions) EXPECT_TRUE(p.x < 38 && p.y > 3);
}

TEST(Trim, AllowsMoreSupportWherePointsAreSparse) {
  Mesh mesh = ground(0, 0, [](Vec3f) { return true; });
  for (float& s : mesh.float_properties[0].values) s = 1.2f;
  FloatProperty density{"density", {}};
  for (const Vec3f p : mesh.positions) density.values.push_back(p.x < 20 ? 4.0f : 25.0f);
  mesh.float_properties.push_back(density);
  Options options;
  options.bridge_m = 0.0;
  const Result result = trim(mesh, options);  // 3 spacings: 1.5 m and 0.6 m
  EXPECT_TRUE(covers(result.mesh, 10.1f, 20.1f));
  EXPECT_FALSE(covers(result.mesh, 30.1f, 20.1f));
}

TEST(Trim, DropsSmallPartsButNotThoseThatReachTheEdge) {
  const auto disc = [](Vec3f p, float x, float y) { return std::hypot(p.x - x, p.y - y) < 3.0f; };
  const Mesh mesh = ground(0, 0, [&](Vec3f p) { return disc(p, 20, 20) || disc(p, 40, 10); });
  Options options;
  options.bridge_m = 0.0;
  const Result result = trim(mesh, options);
  EXPECT_EQ(result.counts.small_parts, 1u);
  EXPECT_FALSE(covers(result.mesh, 20.1f, 20.1f));
  EXPECT_TRUE(covers(result.mesh, 39.1f, 10.1f));
  options.min_area_m2 = 10.0;
  EXPECT_TRUE(covers(trim(mesh, options).mesh, 20.1f, 20.1f));
}

TEST(Trim, LeavesNoVertexWhereTwoPartsTouch) {
  const Mesh mesh = ground(0, 0, [&](Vec3f p) { return (p.x <= 20) == (p.y <= 20); });
  Options options;
  options.bridge_m = 0.0;
  const Result result = trim(mesh, options);
  const auto report = check_topology(result.mesh.triangles, result.mesh.positions.size(), 1);
  EXPECT_TRUE(report.is_manifold());
  EXPECT_EQ(report.isolated_vertices, 0u);
}

/// Open edges on the plane x = 40, by their ends' coordinates.
std::set<std::array<float, 4>> edges_on_plane(const Mesh& mesh) {
  std::set<std::array<float, 4>> edges;
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 1);
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    const Vec3f a = mesh.positions[mesh.triangles[h / 3][h % 3]];
    const Vec3f b = mesh.positions[mesh.triangles[h / 3][(h % 3 + 1) % 3]];
    if (twins[h] != kOpenEdge || a.x != 40.0f || b.x != 40.0f) continue;
    edges.insert(a.y < b.y ? std::array{a.y, a.z, b.y, b.z} : std::array{b.y, b.z, a.y, a.z});
  }
  return edges;
}

TEST(Trim, DecidesAlikeOnTheEdgeThatTwoTilesShare) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    // Blots of random size and place, many of them across the edge x = 40.
    std::vector<Vec3f> blots;
    for (std::uint64_t i = 0; i < 14; ++i) {
      CounterRandom random(seed, 0, i);
      blots.push_back(
          Vec3d{random.uniform(30, 50), random.uniform(0, 40), random.uniform(1, 9)}.cast<float>());
    }
    const auto measured = [&](Vec3f p) {
      return std::none_of(blots.begin(), blots.end(), [&](Vec3f b) {
        return std::abs(p.x - b.x) < b.z && std::abs(p.y - b.y) < 0.6f * b.z;
      });
    };
    Options options;
    options.bridge_m = 6.0;
    const Mesh west = trim(ground(0, 0, measured), options).mesh;
    const Mesh east = trim(ground(40, 0, measured), options).mesh;
    const auto edges = edges_on_plane(west);
    EXPECT_EQ(edges, edges_on_plane(east)) << "seed " << seed;
    EXPECT_LT(edges.size(), 80u);
    EXPECT_GT(edges.size(), 5u);
  }
}

TEST(Trim, TakesMeshesWithoutTrianglesAndRefusesThoseWithoutSupport) {
  Mesh none;
  EXPECT_THROW(trim(none, {}), InputError);
  none.float_properties.push_back({"support", {}});
  EXPECT_TRUE(trim(none, {}).mesh.triangles.empty());
  Mesh one;
  one.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  one.float_properties.push_back({"support", {0.1f, 0.1f, 0.1f}});
  EXPECT_EQ(trim(one, {}).mesh.triangles.size(), 1u);
  one.float_properties[0].values[1] = NAN;
  Options options;
  options.bridge_m = 0.0;
  EXPECT_EQ(trim(one, options).mesh.triangles.size(), 0u);
}

TEST(AddSupport, MeasuresDistanceAndDensityOfTheNearestPoints) {
  Mesh mesh = test::height_mesh(0, 0, 20, 1.0, [](double, double) { return 0.0; });
  mesh.origin = {100, 200, 300};
  OrientedPoints points;
  points.origin = {90, 190, 290};
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 80; ++j) {
      points.positions.push_back(
          {10.0f + 0.25f * static_cast<float>(i), 10.0f + 0.25f * static_cast<float>(j), 10.0f});
    }
  }
  add_support(mesh, points, 2);
  const auto& support = *find_float_property(mesh, "support");
  const auto& density = *find_float_property(mesh, "density");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3f p = mesh.positions[v];
    const float dx = std::max(0.0f, p.x - 9.75f), dy = std::max(0.0f, p.y - 19.75f);
    EXPECT_NEAR(support[v], std::hypot(dx, dy), 1e-4f);
    // 16 points/m²; at the rim half of the disc is empty.
    EXPECT_GT(density[v], 4.0f);
    EXPECT_LT(density[v], 32.0f);
  }
}

}  // namespace
}  // namespace cornice::trim
