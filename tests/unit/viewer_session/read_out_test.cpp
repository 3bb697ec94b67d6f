// SPDX-License-Identifier: GPL-3.0-or-later
// Position, height and slope under the cursor, from what was drawn.
#include <gtest/gtest.h>

#include <cmath>

#include "terrain-viewer/app/pick.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/viewer_session/plates.h"

namespace cornice::viewer {
namespace {

TEST(ReadOut, SaysWhereOnTheGroundThePixelIsAndHowSteepItIsThere) {
  const test::TemporaryFolder folder;
  const OffscreenContext context;
  // 26.57 degrees.
  write_plate(folder / "slope.hlod", [](double x, double) { return 0.5 * x; }, {90, 90, 90});
  Desk desk({folder / "slope.hlod"});
  const Camera camera{plate_corner() + Vec3d{50.0, -60.0, 90.0}, 0.0, -30.0, 50.0};
  desk.draw(camera);
  const auto point = [&](double x, double y) {
    const float depth = read_depth(desk.target(), static_cast<int>(x), static_cast<int>(y));
    return point_of_depth(camera, Desk::kWidth, Desk::kHeight, x, y, depth);
  };
  int ground = 0;
  for (int y = 2; y < Desk::kHeight - 4; y += 7) {
    for (int x = 2; x < Desk::kWidth - 4; x += 9) {
      const auto here = point(x, y);
      if (!here) continue;
      ++ground;
      const Vec3d p = *here - plate_corner();
      EXPECT_NEAR(p.z, 0.5 * p.x, 0.05);
      // What is seen in that pixel is that point.
      const auto pixel = pixel_of_point(camera, Desk::kWidth, Desk::kHeight, *here);
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x, x, 1e-3);
      EXPECT_NEAR(pixel->y, y, 1e-3);
      const bool is_inside = p.x > 5.0 && p.x < 90.0 && p.y > 5.0 && p.y < 90.0;
      if (!is_inside) continue;
      const UnderCursor under = look_under(x, y, *here, point);
      ASSERT_TRUE(under.slope_deg);
      EXPECT_NEAR(*under.slope_deg, std::atan(0.5) * 57.29577951308232, 0.5);
    }
  }
  EXPECT_GT(ground, 50);
  EXPECT_FALSE(point(Desk::kWidth / 2, 1)) << "sky";
}

TEST(ReadOut, HasNoSlopeBesideTheSky) {
  const auto only_here = [](double x, double y) -> std::optional<Vec3d> {
    if (x > 10.0) return std::nullopt;
    return Vec3d{x, y, 0.0};
  };
  EXPECT_FALSE(look_under(9.0, 5.0, {9.0, 5.0, 0.0}, only_here).slope_deg);
  const auto level = look_under(2.0, 5.0, {2.0, 5.0, 0.0}, only_here).slope_deg;
  ASSERT_TRUE(level);
  EXPECT_EQ(*level, 0.0);
}

}  // namespace
}  // namespace cornice::viewer
