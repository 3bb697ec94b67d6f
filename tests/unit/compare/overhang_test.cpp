// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stages/compare/overhangs.h"
#include "tests/support/meshes.h"
#include "tests/unit/compare/pieces.h"

namespace cornice::compare {
namespace {

using test::surface_of;

/// The triangles of a surface on one side of a plane x = at, as a surface of its own.
Surface side_of(const Surface& whole, float at, bool west) {
  Surface part = whole;
  std::erase_if(part.triangles, [&](const Triangle& t) {
    const float x =
        (whole.positions[t[0]].x + whole.positions[t[1]].x + whole.positions[t[2]].x) / 3.0f;
    return (x < at) != west;
  });
  return part;
}

TEST(Overhangs, AreNoneOnAHillHoweverSteep) {
  OverhangFinder finder(0.0);
  finder.add(0, surface_of(test::height_mesh(0, 0, 40, 0.5, [](double x, double y) {
               return 30.0 * std::sin(x) * std::cos(0.7 * y);
             })));
  EXPECT_TRUE(finder.finish(0.0).empty());
  EXPECT_TRUE(finder.triangles_of(0, 3200).empty());
}

TEST(Overhangs, OfASphereAreItsLowerHalf) {
  const Surface sphere = surface_of(test::sphere_mesh(10.0, 5), {2600000, 1200000, 500});
  OverhangFinder finder(0.0);
  finder.add(0, sphere);
  const std::vector<Overhang> found = finder.finish(1.0);
  ASSERT_EQ(found.size(), 1u);
  const double half = 2.0 * std::numbers::pi * 100.0;
  EXPECT_NEAR(found[0].area_m2, half, 0.03 * half);
  EXPECT_NEAR(found[0].plan_m2, 0.5 * half, 0.03 * half);
  EXPECT_NEAR(found[0].depth_m, 20.0, 0.2);
  EXPECT_NEAR(found[0].length_m, 20.0, 0.2);
  EXPECT_NEAR(found[0].height_m, 10.0, 0.5);
  EXPECT_GT(found[0].steepest_deg, 87.0);
  EXPECT_NEAR(found[0].centre.x, 2600000.0, 0.2);
  EXPECT_NEAR(found[0].centre.z, 495.0, 0.3);
  const std::vector<std::uint8_t> marks = finder.triangles_of(0, sphere.triangles.size());
  double marked = 0.0;
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] == 0) continue;
    const Triangle& c = sphere.triangles[t];
    const Vec3f a = sphere.positions[c[0]];
    marked += 0.5 * static_cast<double>(
                        norm(cross(sphere.positions[c[1]] - a, sphere.positions[c[2]] - a)));
  }
  EXPECT_NEAR(marked, found[0].area_m2, 1e-3);
}

TEST(Overhangs, CutByATilesBorderAreOne) {
  const Surface sphere = surface_of(test::sphere_mesh(10.0, 4));
  OverhangFinder whole(0.0), tiled(0.0);
  whole.add(0, sphere);
  tiled.add(0, side_of(sphere, 2.0f, true));
  tiled.add(1, side_of(sphere, 2.0f, false));
  const std::vector<Overhang> one = whole.finish(0.1), two = tiled.finish(0.1);
  ASSERT_EQ(one.size(), 1u);
  ASSERT_EQ(two.size(), 1u);
  EXPECT_NEAR(two[0].area_m2, one[0].area_m2, 1e-6);
  // A sphere faces no way: depth and length are along any two directions.
  EXPECT_NEAR(two[0].depth_m, one[0].depth_m, 0.1);
  EXPECT_NEAR(norm(two[0].centre - one[0].centre), 0.0, 1e-6);
}

TEST(Overhangs, SmallerThanAskedForAreLeftOut) {
  OverhangFinder finder(0.0);
  finder.add(0, surface_of(test::sphere_mesh(0.2, 3)));
  finder.add(1, surface_of(test::sphere_mesh(5.0, 3), {100, 0, 0}));
  EXPECT_EQ(finder.finish(1.0).size(), 1u);
}

TEST(Overhangs, FaceTheWayTheirNormalsPoint) {
  OverhangFinder finder(0.0);
  // The ledge leans out over lower x: its underside looks west.
  finder.add(0, surface_of(test::overhang_mesh(40.0, 10.0, 8.0, 0.25)));
  const std::vector<Overhang> found = finder.finish(1.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].azimuth_deg, 270.0, 2.0);
  EXPECT_NEAR(found[0].length_m, 10.0, 0.3);
}

}  // namespace
}  // namespace cornice::compare
