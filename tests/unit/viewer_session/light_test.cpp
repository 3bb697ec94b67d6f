// SPDX-License-Identifier: GPL-3.0-or-later
// Light and air over the ground, as they are drawn.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "terrain-viewer/render/offscreen_context.h"
#include "terrain-viewer/scene/sun.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/viewer_session/plates.h"

namespace cornice::viewer {
namespace {

int brightness(Colour c) { return c[0] + c[1] + c[2]; }

class Lit : public testing::Test {
 protected:
  /// The middle of a plate that rises to the east.
  Desk rising_east(std::uint8_t grey = 150) {
    write_plate(folder_ / "east.hlod", [](double x, double) { return 0.6 * (x - 50.0); },
                {grey, grey, grey});
    return Desk({folder_ / "east.hlod"});
  }
  /// Dark level ground of 60 km, 1000 m high.
  Desk plain() {
    Mesh mesh = test::height_mesh(0.0, 0.0, 100, 600.0, [](double, double) { return 0.0; });
    mesh.origin = plate_corner();
    for (const char* channel : {"red", "green", "blue"})
      mesh.byte_properties.push_back(
          {channel, std::vector<std::uint8_t>(mesh.positions.size(), 60)});
    test::write_hierarchy(folder_ / "plain.hlod", mesh, {});
    return Desk({folder_ / "plain.hlod"});
  }
  /// From its southern edge, 400 m over it, along the horizon, which is in the middle.
  static Camera along_plain() {
    return {plate_corner() + Vec3d{30000.0, 100.0, 400.0}, 0.0, 0.0, 40.0};
  }
  /// What is seen so many pixels below the horizon.
  static Colour below_horizon(const Picture& picture, int rows) {
    return picture
        .pixels[std::size_t{Desk::kWidth} * (Desk::kHeight / 2 + rows) + Desk::kWidth / 2];
  }

  test::TemporaryFolder folder_;
  OffscreenContext context_;
};

TEST_F(Lit, GroundIsLighterTheMoreItFacesTheSun) {
  Desk desk = rising_east();
  Style& style = desk.session().style();
  // It falls to the west.
  for (const double elevation : {10.0, 30.0, 50.0}) {
    std::vector<int> seen;
    for (const double azimuth : {90.0, 45.0, 0.0, 315.0, 270.0}) {
      style.sun = sun_direction(azimuth, elevation);
      seen.push_back(brightness(desk.middle()));
    }
    for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_GE(seen[i], seen[i - 1]) << elevation;
    EXPECT_GT(seen.back(), seen.front() + 60) << elevation;
  }
}

TEST_F(Lit, NightIsDarkAndShowsTheGroundAllTheSame) {
  Desk desk = rising_east();
  Style& style = desk.session().style();
  const auto at = [&](double elevation) {
    style.sun = sun_direction(270.0, elevation);
    return brightness(desk.middle());
  };
  const int day = at(40.0), low = at(5.0), dusk = at(-4.0), night = at(-30.0);
  EXPECT_GT(day, low);
  EXPECT_GT(low, dusk);
  EXPECT_GT(dusk, night);
  EXPECT_LT(night, day / 3);
  EXPECT_GT(night, 60);
  EXPECT_EQ(night, at(-60.0));
}

TEST_F(Lit, ALowSunMakesWhatItShinesOnWarmer) {
  Desk desk = rising_east(80);
  Style& style = desk.session().style();
  const auto warmth = [&](double elevation) {
    style.sun = sun_direction(270.0, elevation);
    const Colour c = desk.middle();
    return int{c[0]} - int{c[2]};
  };
  EXPECT_GT(warmth(8.0), warmth(45.0) + 5);
}

TEST_F(Lit, DarkGroundFarAwayTurnsBlueAndThenPale) {
  Desk desk = plain();
  desk.session().style().shading = Shading::kColour;
  const Picture picture = desk.draw(along_plain());
  // 60 pixels are 20 degrees: 1.2, 3, 6, 18 km.
  int blue = -255, light = 0;
  for (const int rows : {58, 24, 12, 4}) {
    const Colour c = below_horizon(picture, rows);
    EXPECT_GT(int{c[2]} - int{c[0]}, blue) << rows;
    EXPECT_GT(brightness(c), light) << rows;
    blue = int{c[2]} - int{c[0]};
    light = brightness(c);
  }
  desk.session().style().haze_range_m = 0.0;
  const Picture airless = desk.draw(along_plain());
  EXPECT_LT(brightness(below_horizon(airless, 4)), light - 60);
}

TEST_F(Lit, HazeEndsInTheColourOfTheSkyAtTheHorizonAtAnyTimeOfDay) {
  Desk desk = plain();
  Style& style = desk.session().style();
  style.haze_range_m = 800.0;
  style.haze_height_m = 0.0;
  for (const double elevation : {45.0, 8.0, 1.0, -6.0, -40.0}) {
    for (const double azimuth : {0.0, 130.0}) {
      style.sun = sun_direction(azimuth, elevation);
      const Picture picture = desk.draw(along_plain());
      const Colour ground = below_horizon(picture, 2);
      Camera beyond = along_plain();
      beyond.eye.y += 70000.0;  // nothing but sky
      const Colour sky = below_horizon(desk.draw(beyond), 2);
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(ground[c], sky[c], 2) << elevation;
    }
  }
}

}  // namespace
}  // namespace cornice::viewer
