// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "stages/compare/height_grid.h"
#include "stages/compare/profile.h"
#include "tests/support/meshes.h"
#include "tests/unit/compare/pieces.h"

namespace cornice::compare {
namespace {

using test::cloud_of;
using test::surface_of;

double slope_height(double x, double y) { return 0.3 * x + 0.1 * y; }

TEST(HeightGrid, HoldsTheSurfaceAtPixelCentres) {
  const GridFrame frame = frame_over({0, 0, 20, 20}, 0.5, 0.0, 0.0);
  EXPECT_EQ(frame.width, 40);
  EXPECT_EQ(frame.height, 40);
  HeightGrid grid(frame);
  // Vertices on pixel centres, edges through them: no centre may fall between two triangles.
  grid.add(surface_of(test::height_mesh(-0.25, -0.25, 42, 0.5, slope_height)));
  grid.finish();
  EXPECT_EQ(grid.filled(), frame.pixels());
  for (int row = 0; row < 40; ++row) {
    for (int col = 0; col < 40; ++col) {
      const double x = 0.25 + 0.5 * col, y = 20.0 - 0.25 - 0.5 * row;
      const std::size_t at = static_cast<std::size_t>(row * 40 + col);
      EXPECT_NEAR(grid.top(at), slope_height(x, y), 1e-5);
      EXPECT_NEAR(grid.gap(at), 0.0, 1e-5);
    }
  }
}

TEST(HeightGrid, TellsColumnsWithTwoLayers) {
  const Mesh ledge = test::overhang_mesh(60.0, 10.0, 8.0, 0.25);
  HeightGrid grid(frame_over({0, 1, 70, 9}, 0.5, 0.0, 0.0));
  grid.add(surface_of(ledge));
  grid.finish();
  std::size_t layered = 0;
  for (std::size_t i = 0; i < grid.frame().pixels(); ++i) {
    if (grid.gap(i) > 0.25f) ++layered;
  }
  // The profile folds back over the depth of the ledge, about 8 m wide, 8 m along.
  const double area = static_cast<double>(layered) * 0.25;
  EXPECT_GT(area, 30.0);
  EXPECT_LT(area, 140.0);
}

TEST(HeightGrid, AveragesThePointsOfClouds) {
  HeightGrid grid(frame_over({0, 0, 2, 2}, 1.0, 0.0, 0.0));
  grid.add(cloud_of({{0.5f, 1.5f, 1.0f}, {0.6f, 1.2f, 2.0f}, {0.1f, 1.9f, 6.0f}}, {0, 0, 100}));
  grid.finish();
  EXPECT_NEAR(grid.top(0), 103.0, 1e-5);
  EXPECT_TRUE(std::isnan(grid.top(1)));
  EXPECT_EQ(grid.filled(), 1u);
}

TEST(Difference, IsPositiveWhereTheSecondLiesHigher) {
  HeightGrid a(frame_over({0, 0, 4, 4}, 1.0, 0.0, 0.0)), b(a.frame());
  a.add(surface_of(test::height_mesh(-1, -1, 6, 1.0, slope_height)));
  b.add(surface_of(test::height_mesh(-1, -1, 6, 1.0, slope_height), {0, 0, 0.75}));
  a.finish(), b.finish();
  const Raster raster = difference(a, b, {});
  for (const float value : raster.values) EXPECT_NEAR(value, 0.75f, 1e-5f);
}

TEST(Profile, CutsSurfacesAndTakesPointsNearTheLine) {
  Profile profile{{1.0, 2.2, 9.0, 2.2}, {}, {}};
  cut_profile(surface_of(test::height_mesh(0, 0, 10, 1.0, slope_height)), 0, 0.5, profile);
  cut_profile(cloud_of({{5, 2.4f, 7}, {5, 3, 7}, {0, 2.2f, 7}}), 1, 0.5, profile);
  double length = 0.0;
  for (const auto& [a, b] : profile.segments[0]) {
    length += std::abs(b.along_m - a.along_m);
    EXPECT_NEAR(a.height_m, slope_height(1.0 + a.along_m, 2.2), 1e-5);
    EXPECT_NEAR(b.height_m, slope_height(1.0 + b.along_m, 2.2), 1e-5);
  }
  EXPECT_NEAR(length, 8.0, 1e-5);
  ASSERT_EQ(profile.points[1].size(), 1u);
  EXPECT_NEAR(profile.points[1][0].along_m, 4.0, 1e-6);
  const std::string svg = profile_svg(profile, {"a<b", "c"});
  EXPECT_NE(svg.find("a&lt;b"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace cornice::compare
