// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/topology.h"
#include "tests/support/meshes.h"

namespace cornice::dem {
namespace {

constexpr float kNothing = -9999.0f;

/// Pixels of one metre whose centres lie at whole numbers and a half.
RasterGrid grid_of(int width, int height, double west = 0.0, double south = 0.0) {
  return {width, height, west, south + height, 1.0};
}

Layers layers_of(const std::vector<Mesh>& meshes, const RasterGrid& grid, int threads = 1) {
  Layers layers(grid, {0, 0, grid.width, grid.height});
  for (const Mesh& mesh : meshes) layers.add(mesh, threads);
  return layers;
}

/// Height of a triangle above a place in plan, in doubles; nothing beside it.
std::optional<double> height_at(const Mesh& mesh, const Triangle& t, double x, double y) {
  std::array<Vec3d, 3> p;
  for (int k = 0; k < 3; ++k) p[k] = mesh.origin + mesh.positions[t[k]].cast<double>();
  const auto area = [](Vec3d a, Vec3d b, double px, double py) {
    return (b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x);
  };
  const double whole = area(p[0], p[1], p[2].x, p[2].y);
  const double u = area(p[1], p[2], x, y) / whole, v = area(p[2], p[0], x, y) / whole;
  const double w = area(p[0], p[1], x, y) / whole;
  if (!(u > 0.0 && v > 0.0 && w > 0.0)) return std::nullopt;
  return u * p[0].z + v * p[1].z + w * p[2].z;
}

TEST(Layers, AgreeWithEveryTriangleTriedAtEveryPixel) {
  Mesh soup;
  soup.origin = {500000.0, 200000.0, 1000.0};
  CounterRandom random(3, 0, 0);
  for (std::uint32_t t = 0; t < 400; ++t) {
    const double x = random.uniform(-3.0, 33.0), y = random.uniform(-3.0, 23.0);
    for (int k = 0; k < 3; ++k) {
      soup.positions.push_back(
          Vec3d{x + random.uniform(-6, 6), y + random.uniform(-6, 6), random.uniform(-50, 50)}
              .cast<float>());
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const RasterGrid grid = grid_of(30, 20, 500000.0, 200000.0);
  const Layers layers = layers_of({soup}, grid);
  const auto high = layers.highest(kNothing), low = layers.lowest(kNothing);
  const auto mean = layers.mean(kNothing), count = layers.counts();
  for (int row = 0; row < grid.height; ++row) {
    for (int col = 0; col < grid.width; ++col) {
      std::vector<double> heights;
      for (const Triangle& t : soup.triangles) {
        const auto z = height_at(soup, t, grid.west + col + 0.5, grid.north - row - 0.5);
        if (z) heights.push_back(*z);
      }
      const auto i = static_cast<std::size_t>(row * grid.width + col);
      ASSERT_EQ(count[i], static_cast<float>(heights.size()));
      if (heights.empty()) {
        EXPECT_EQ(high[i], kNothing);
        continue;
      }
      double sum = 0.0;
      for (const double z : heights) sum += z;
      // A millionth of a pixel in plan, on triangles that can be nearly upright.
      EXPECT_NEAR(high[i], *std::max_element(heights.begin(), heights.end()), 2e-2);
      EXPECT_NEAR(low[i], *std::min_element(heights.begin(), heights.end()), 2e-2);
      EXPECT_NEAR(mean[i], sum / static_cast<double>(heights.size()), 2e-2);
    }
  }
}

TEST(Layers, CountACentreOnSharedEdgesAndVerticesOnce) {
  // Vertices on all centres; both diagonals occur.
  Mesh mesh = test::height_mesh(0.5, 0.5, 8, 1.0, [](double x, double y) { return x + 10.0 * y; });
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 4)
    std::swap(mesh.triangles[t], mesh.triangles[t + 1]);
  const RasterGrid grid = grid_of(9, 9);
  const Layers layers = layers_of({mesh}, grid);
  const auto high = layers.highest(kNothing);
  for (std::size_t i = 0; i < 81; ++i) {
    EXPECT_EQ(layers.counts()[i], 1.0f);
    EXPECT_EQ(high[i], static_cast<float>(0.5 + static_cast<double>(i % 9) +
                                          10.0 * (8.5 - static_cast<double>(i / 9))));
  }
  EXPECT_EQ(layers.mean(kNothing), high);
  EXPECT_EQ(layers.lowest(kNothing), high);
}

TEST(Layers, FindThreeOfThemInALedge) {
  const Mesh ledge = test::overhang_mesh(60.0, 20.0, 8.0, 0.25);
  const RasterGrid grid = grid_of(60, 20);
  const Layers layers = layers_of({ledge}, grid);
  const auto count = layers.counts(), high = layers.highest(kNothing),
             low = layers.lowest(kNothing);
  const auto middle = static_cast<std::size_t>(10 * grid.width + 30);
  EXPECT_EQ(count[middle], 3.0f);
  EXPECT_GT(high[middle], low[middle] + 4.0f);
  EXPECT_EQ(count[static_cast<std::size_t>(10 * grid.width + 5)], 1.0f);
  for (const float n : count) EXPECT_EQ(std::fmod(n, 2.0f), 1.0f);
  EXPECT_GE(layers.pixels_with(2), 20u * 3u);
  EXPECT_LT(layers.pixels_with(2), 20u * 20u);
}

TEST(Layers, AreTheSameInAnyOrderAndWithAnyNumberOfThreads) {
  const Mesh ledge = test::overhang_mesh(40.0, 10.0, 6.0, 0.3);
  Mesh turned = ledge;
  std::reverse(turned.triangles.begin(), turned.triangles.end());
  const Mesh ground =
      test::height_mesh(0.0, 0.0, 40, 1.0, [](double x, double) { return 0.1 * x; });
  const RasterGrid grid = grid_of(45, 12);
  const Layers one = layers_of({ledge, ground}, grid, 1),
               two = layers_of({ground, turned}, grid, 2);
  EXPECT_EQ(one.highest(kNothing), two.highest(kNothing));
  EXPECT_EQ(one.mean(kNothing), two.mean(kNothing));
  EXPECT_EQ(one.counts(), two.counts());
}

TEST(Layers, OfBlocksAreThoseOfTheWhole) {
  const Mesh ledge = test::overhang_mesh(40.0, 12.0, 6.0, 0.3);
  const RasterGrid grid = grid_of(40, 12);
  const auto whole = layers_of({ledge}, grid).mean(kNothing);
  for (const PixelRect& rect : {PixelRect{0, 0, 13, 5}, PixelRect{13, 5, 27, 7}}) {
    Layers block(grid, rect);
    block.add(ledge, 1);
    const auto part = block.mean(kNothing);
    for (std::int64_t i = 0; i < rect.width * rect.height; ++i) {
      const std::int64_t at = (rect.row + i / rect.width) * grid.width + rect.col + i % rect.width;
      ASSERT_EQ(part[static_cast<std::size_t>(i)], whole[static_cast<std::size_t>(at)]);
    }
  }
}

TEST(Layers, HoldOnTrianglesOfManyKilometres) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {20000, 0, 2000}, {0, 20000, 4000}};
  mesh.triangles = {{0, 1, 2}};
  const RasterGrid grid = grid_of(3, 3, 5000.0, 7000.0);
  const auto high = layers_of({mesh}, grid).highest(kNothing);
  EXPECT_NEAR(high[4], 0.1 * 5001.5 + 0.2 * 7001.5, 1e-3);
}

TEST(Layers, UprightTrianglesCoverNothing) {
  Mesh wall;
  wall.positions = {{0, 0.5f, 0}, {5, 0.5f, 0}, {0, 0.5f, 9}};
  wall.triangles = {{0, 1, 2}};
  EXPECT_EQ(layers_of({wall}, grid_of(5, 5)).pixels_with(1), 0u);
}

}  // namespace
}  // namespace cornice::dem
