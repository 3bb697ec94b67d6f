// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "core/mesh/quality.h"
#include "tests/property/poisson_extract/fields.h"

namespace cornice {
namespace {

using namespace cornice::test;

Surface extract(const Field& field, const ExtractOptions& options) {
  return extract_surface(FieldValues(field), field.lattice(), options);
}

Function sphere(Vec3d centre, double radius) {
  return [=](double x, double y, double z) {
    return static_cast<float>(norm(Vec3d{x, y, z} - centre) - radius);
  };
}

double signed_volume(const Mesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                c = mesh.positions[t[2]].cast<double>();
    sum += dot(a, cross(b, c)) / 6.0;
  }
  return sum;
}

TEST(Extract, ASphereIsClosedOutwardsAndOfItsVolume) {
  const double radius = 13.37;
  const Field field = sampled(sphere({1.2, -3.4, 5.6}, radius), {{-3, -3, -2}, {2, 2, 3}});
  const LatticeBox window{-20, -24, 20, 20};
  for (const double weld : {0.0, 0.2, 0.45}) {
    const Surface surface = extract(field, window_options(window, 2, weld));
    expect_sound(surface, field.lattice(), window);
    const TopologyReport topology =
        check_topology(surface.mesh.triangles, surface.mesh.positions.size(), 1);
    EXPECT_EQ(topology.open_edges, 0u);
    EXPECT_EQ(topology.components, 1u);
    const double true_volume = 4.0 / 3.0 * std::numbers::pi * std::pow(0.5 * radius, 3);
    EXPECT_NEAR(signed_volume(surface.mesh), true_volume, 0.01 * true_volume) << weld;
    for (std::size_t v = 0; v < surface.mesh.positions.size(); ++v) {
      const Vec3d p = surface.mesh.positions[v].cast<double>() + surface.mesh.origin;
      const Vec3d out = p - Vec3d{1.2, -3.4, 5.6} * 0.5;
      EXPECT_NEAR(norm(out), 0.5 * radius, 0.006);
      EXPECT_GT(dot(normalized(out), surface.mesh.normals[v].cast<double>()), 0.998);
    }
  }
}

/// Triangles (bytes) with no corner on the window's border planes, which keep their vertices.
std::vector<std::uint8_t> inside(const Mesh& mesh, float width) {
  std::vector<std::uint8_t> chosen;
  for (const auto& t : mesh.triangles) {
    bool all = true;
    for (const std::uint32_t v : t) {
      const Vec3f p = mesh.positions[v];
      all = all && p.x > 0.5f && p.y > 0.5f && p.x < width - 0.5f && p.y < width - 0.5f;
    }
    chosen.push_back(all ? 1 : 0);
  }
  return chosen;
}

TEST(Extract, TheWeldRemovesSlivers) {
  const Function hills = [](double x, double y, double z) {
    return static_cast<float>(z - 3.0 * std::sin(0.11 * x) * std::cos(0.07 * y) - 0.3 * x);
  };
  const Field field = sampled(hills, {{-1, -1, -3}, {13, 13, 5}});
  const LatticeBox window{0, 0, 100, 100};
  const Mesh plain = extract(field, window_options(window, 2, 0.0)).mesh;
  const Surface welded = extract(field, window_options(window, 2, ExtractOptions{}.weld));
  const QualityReport before =
      measure_quality(plain.positions, plain.triangles, 1, inside(plain, 50.0f));
  const QualityReport after =
      measure_quality(welded.mesh.positions, welded.mesh.triangles, 1, inside(welded.mesh, 50.0f));
  EXPECT_GT(welded.welded, 0u);
  EXPECT_LT(after.triangles, before.triangles * 4 / 5);
  EXPECT_LT(before.share_min_angle_20(), 0.9);
  EXPECT_GT(after.share_min_angle_20(), 0.995);
  EXPECT_EQ(after.without_area, 0u);
}

class ExtractNoise : public testing::TestWithParam<int> {};

TEST_P(ExtractNoise, WhiteNoiseGivesAManifoldClosedButForTheWindow) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const BrickBox box{{-1, -1, -1}, {4, 4, 3}};
  // Closed above and below: positive on top, negative at the bottom.
  const Function noise = white_noise(seed);
  const Function capped = [&](double x, double y, double z) {
    return z > 20 ? 1.0f : z < 0 ? -1.0f : noise(x, y, z);
  };
  const Field field = sampled(capped, box);
  const LatticeBox window{1, 3, 29, 30};
  for (const double weld : {0.0, 0.2, 0.49}) {
    SCOPED_TRACE(weld);
    expect_sound(extract(field, window_options(window, 2, weld)), field.lattice(), window);
  }
}

TEST_P(ExtractNoise, SmoothNoiseOfAllWavelengthsGivesAManifold) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  for (const double wavelength : {3.0, 6.0, 15.0}) {
    const Function noise = smooth_noise(seed, wavelength);
    const Function capped = [&](double x, double y, double z) {
      return z > 20 ? 1.0f : z < 0 ? -1.0f : noise(x, y, z);
    };
    const Field field = sampled(capped, {{-1, -1, -1}, {5, 5, 3}});
    const LatticeBox window{0, 5, 33, 37};
    for (const double weld : {0.2, 0.49}) {
      SCOPED_TRACE(weld);
      SCOPED_TRACE(wavelength);
      expect_sound(extract(field, window_options(window, 2, weld)), field.lattice(), window);
    }
  }
}

TEST_P(ExtractNoise, FewValuesWithManyExactZerosGiveAManifold) {
  const Function noise = white_noise(static_cast<std::uint64_t>(GetParam()) + 100);
  const Function few = [&](double x, double y, double z) {
    if (z > 20) return 1.0f;
    if (z < 0) return -1.0f;
    return std::round(noise(x, y, z) * 1.6f);
  };
  const Field field = sampled(few, {{-1, -1, -1}, {3, 3, 3}});
  const LatticeBox window{0, 0, 24, 24};
  expect_sound(extract(field, window_options(window)), field.lattice(), window);
}

INSTANTIATE_TEST_SUITE_P(Seeds, ExtractNoise, testing::Range(1, 9));

TEST(Extract, CoarseAndFineRegionsMeetWithoutCracks) {
  const Function ground = smooth_noise(3, 24.0, 6);
  const Function capped = [&](double x, double y, double z) {
    return 0.5f * ground(x, y, 0) + static_cast<float>(0.3 * z) - 3.0f;
  };
  const Field field =
      sampled_adaptively(capped, {{-2, -2, -2}, {9, 9, 5}}, 4, [](int level, BrickKey brick) {
        return (brick.x * 5 + brick.y * 3 + brick.z + level) % 3 != 0 && brick.x > (2 >> level);
      });
  const LatticeBox window{0, 0, 64, 60};
  const Surface surface = extract(field, window_options(window));
  EXPECT_GT(surface.mesh.triangles.size(), 1000u);
  expect_sound(surface, field.lattice(), window);
}

TEST(Extract, WindowsThatShareABorderPlaneHaveTheSameVerticesAndNormalsOnIt) {
  const Function noise = white_noise(5);
  const Function capped = [&](double x, double y, double z) {
    return z > 20 ? 1.0f : z < 0 ? -1.0f : noise(x, y, z);
  };
  const Field field = sampled(capped, {{-2, -2, -1}, {6, 6, 3}});
  const LatticeBox west{0, 0, 19, 30}, south{19, 0, 37, 13}, north{19, 13, 37, 30};
  const std::vector<LatticeBox> all{west, south, north};
  using Key = std::array<double, 6>;
  std::vector<std::vector<Key>> on_plane;
  for (const LatticeBox& window : all) {
    ExtractOptions options = window_options(window);
    options.borders = all;
    const Surface surface = extract(field, options);
    expect_sound(surface, field.lattice(), window);
    std::vector<Key>& keys = on_plane.emplace_back();
    for (std::size_t v = 0; v < surface.mesh.positions.size(); ++v) {
      const Vec3d p = surface.mesh.origin + surface.mesh.positions[v].cast<double>();
      const Vec3f n = surface.mesh.normals[v];
      if (p.x == 9.5) keys.push_back({p.y, p.z, n.x, n.y, n.z, 0});
    }
    std::sort(keys.begin(), keys.end());
  }
  std::vector<Key> east = on_plane[1];
  east.insert(east.end(), on_plane[2].begin(), on_plane[2].end());
  std::sort(east.begin(), east.end());
  east.erase(std::unique(east.begin(), east.end()), east.end());
  EXPECT_GT(east.size(), 500u);
  EXPECT_EQ(on_plane[0], east);
}

TEST(Extract, TheNumberOfThreadsChangesNoByte) {
  const Function noise = smooth_noise(9, 8.0);
  const Field field = sampled(noise, {{-1, -1, -1}, {9, 9, 9}});
  const LatticeBox window{0, 0, 64, 64};
  const Surface one = extract(field, window_options(window, 1));
  const Surface two = extract(field, window_options(window, 2));
  ASSERT_GT(one.mesh.triangles.size(), 10'000u);
  EXPECT_EQ(one.mesh.positions, two.mesh.positions);
  EXPECT_EQ(one.mesh.triangles, two.mesh.triangles);
  EXPECT_EQ(one.mesh.normals, two.mesh.normals);
}

TEST(Extract, WhereTheFieldEndsSoDoesTheSurface) {
  const Function plane = [](double, double, double z) { return static_cast<float>(z - 3.3); };
  const Field field = sampled(plane, {{0, 0, 0}, {3, 3, 1}});
  const LatticeBox window{-16, -16, 60, 60};
  const Surface surface = extract(field, window_options(window));
  const TopologyReport topology =
      check_topology(surface.mesh.triangles, surface.mesh.positions.size(), 1);
  EXPECT_TRUE(topology.is_manifold());
  EXPECT_EQ(topology.isolated_vertices, 0u);
  // Nodes 0 .. 39 are there, a brick beyond the box for the closure included.
  EXPECT_EQ(surface.mesh.positions.size(), 40u * 40u);
  EXPECT_EQ(surface.mesh.triangles.size(), 2u * 39u * 39u);
}

TEST(Extract, AnEmptyFieldHasNoSurface) {
  const Field field({0.5}, {});
  const Surface surface = extract(field, window_options({0, 0, 100, 100}));
  EXPECT_TRUE(surface.mesh.triangles.empty());
  EXPECT_TRUE(surface.mesh.positions.empty());
}

TEST(Extract, AWindowTooWideForFloatsIsRefused) {
  const Function plane = [](double, double, double z) { return static_cast<float>(z - 3.3); };
  const Field field = sampled(plane, {{0, 0, 0}, {1, 1, 1}});
  EXPECT_THROW(extract(field, window_options({0, 0, 20'000, 100})), std::runtime_error);
}

}  // namespace
}  // namespace cornice
