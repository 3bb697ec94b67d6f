// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/quality.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/meshes.h"

namespace cornice {
namespace {

TEST(Shapes, OfEqualSidesAreTheBest) {
  const Vec3d a{0, 0, 0}, b{1, 0, 0}, c{0.5, std::sqrt(0.75), 0};
  EXPECT_NEAR(smallest_angle_deg(a, b, c), 60.0, 1e-9);
  EXPECT_NEAR(radius_ratio(a, b, c), 1.0, 1e-12);
}

TEST(Shapes, OfARightTriangleAreAsInTheBooks) {
  // Sides 3, 4, 5: inradius 1, circumradius 2.5.
  EXPECT_NEAR(radius_ratio({0, 0, 0}, {3, 0, 0}, {0, 4, 0}), 0.8, 1e-12);
  EXPECT_NEAR(smallest_angle_deg({0, 0, 0}, {3, 0, 0}, {0, 4, 0}),
              std::atan2(3, 4) * 180 / 3.14159265358979, 1e-6);
}

TEST(Shapes, WithoutAreaAreTheWorst) {
  EXPECT_EQ(smallest_angle_deg({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), 0.0);
  EXPECT_EQ(radius_ratio({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), 0.0);
  EXPECT_EQ(radius_ratio({1, 0, 0}, {1, 0, 0}, {1, 0, 0}), 0.0);
}

TEST(MeasureQuality, CountsThinTrianglesAmongThoseChosen) {
  Mesh mesh = test::height_mesh(0, 0, 4, 1.0, [](double, double) { return 0.0; });
  mesh.positions.push_back({10, 0, 0});
  mesh.positions.push_back({11, 0, 0});
  mesh.positions.push_back({10.5f, 0.01f, 0});
  mesh.triangles.push_back({25, 26, 27});
  const QualityReport all = measure_quality(mesh.positions, mesh.triangles, 2);
  EXPECT_EQ(all.triangles, 33u);
  EXPECT_EQ(all.below_20_deg, 1u);
  EXPECT_NEAR(all.share_min_angle_20(), 32.0 / 33.0, 1e-12);
  EXPECT_NEAR(all.smallest_angle_deg, 1.146, 0.001);
  std::vector<std::uint8_t> chosen(33, 1);
  chosen.back() = 0;
  EXPECT_EQ(measure_quality(mesh.positions, mesh.triangles, 1, chosen).below_20_deg, 0u);
  EXPECT_EQ(measure_quality({}, {}, 1).share_min_angle_20(), 1.0);
}

}  // namespace
}  // namespace cornice
