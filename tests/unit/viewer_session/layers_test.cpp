// SPDX-License-Identifier: GPL-3.0-or-later
// Several layers in one picture.
#include <gtest/gtest.h>

#include <cstdlib>

#include "terrain-viewer/render/offscreen_context.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/viewer_session/plates.h"

namespace cornice::viewer {
namespace {

class Layered : public testing::Test {
 protected:
  Layered() {
    const auto flat = [](double, double) { return 0.0; };
    write_plate(folder_ / "red.hlod", flat, {200, 30, 30});
    write_plate(folder_ / "blue.hlod", flat, {30, 30, 200});
    write_plate(folder_ / "high.hlod", [](double, double) { return 5.0; }, {30, 200, 30});
  }
  static bool is_red(Colour c) { return c[0] > 2 * c[1] && c[0] > 2 * c[2]; }
  static bool is_green(Colour c) { return c[1] > 2 * c[0] && c[1] > 2 * c[2]; }
  static bool is_blue(Colour c) { return c[2] > 2 * c[0] && c[2] > 2 * c[1]; }

  test::TemporaryFolder folder_;
  OffscreenContext context_;
};

TEST_F(Layered, TheFirstCountsWhereTwoAreAtTheSamePlaceAndTheNearerElsewhere) {
  Desk desk({folder_ / "red.hlod", folder_ / "blue.hlod", folder_ / "high.hlod"});
  EXPECT_TRUE(is_green(desk.middle()));
  desk.session().looks()[2].is_visible = false;
  EXPECT_TRUE(is_red(desk.middle()));
  desk.session().swap_layers(0, 1);
  EXPECT_TRUE(is_blue(desk.middle()));
  EXPECT_EQ(desk.session().layers()[0]->name(), "blue.hlod");
  desk.session().looks()[0].is_visible = false;
  EXPECT_TRUE(is_red(desk.middle()));
}

TEST_F(Layered, AreDrawnPlainAndNamedWhereTheyLackWhatTheShadingPaints) {
  Desk desk({folder_ / "red.hlod", folder_ / "blue.hlod"});
  Session& session = desk.session();
  for (const Shading shading : {Shading::kColour, Shading::kSupport, Shading::kSlope}) {
    session.style().shading = shading;
    EXPECT_EQ(session.missing_values(), "");
  }
  session.style().shading = Shading::kPlain;
  const Colour plain = desk.middle();
  session.style().shading = Shading::kSource;
  EXPECT_EQ(desk.middle(), plain);
  EXPECT_EQ(session.missing_values(), "red.hlod, blue.hlod without sources: drawn plain");
  session.looks()[0].is_visible = false;
  EXPECT_EQ(session.missing_values(), "blue.hlod without sources: drawn plain");
}

TEST_F(Layered, SwapsTheLooksWithTheLayers) {
  Desk desk({folder_ / "red.hlod", folder_ / "blue.hlod"});
  desk.session().looks()[0] = {false, 0.25};
  desk.session().swap_layers(0, 1);
  EXPECT_TRUE(desk.session().looks()[0].is_visible);
  EXPECT_FALSE(desk.session().looks()[1].is_visible);
  EXPECT_EQ(desk.session().looks()[1].opacity, 0.25);
  EXPECT_TRUE(is_blue(desk.middle()));
}

TEST_F(Layered, LetsWhatIsBelowShowThroughAsFarAsItsOpacitySays) {
  Desk desk({folder_ / "red.hlod", folder_ / "high.hlod"});
  LayerLook& high = desk.session().looks()[1];
  const Colour above = desk.middle();
  high.is_visible = false;
  const Colour below = desk.middle();
  high.is_visible = true;
  for (const double opacity : {0.25, 0.5, 0.8}) {
    high.opacity = opacity;
    const Colour mixed = desk.middle();
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(mixed[c], opacity * above[c] + (1.0 - opacity) * below[c], 1.5) << opacity;
  }
}

TEST_F(Layered, BlinkShowsOneOfTheLastTwoInsteadOfTheOther) {
  Desk desk({folder_ / "high.hlod", folder_ / "red.hlod", folder_ / "blue.hlod"});
  desk.session().looks()[0].is_visible = false;
  desk.session().blink();
  EXPECT_TRUE(is_red(desk.middle()));
  for (int i = 0; i < 3; ++i) {
    desk.session().blink();
    EXPECT_TRUE(is_blue(desk.middle()));
    desk.session().blink();
    EXPECT_TRUE(is_red(desk.middle()));
  }
  EXPECT_FALSE(desk.session().looks()[0].is_visible) << "others stay as they are";
  Desk alone({folder_ / "red.hlod"});
  alone.session().blink();
  EXPECT_TRUE(is_red(alone.middle())) << "one layer has nothing to blink with";
}

TEST_F(Layered, SwipeShowsTheLastLayerRightOfItsLineAndTheOthersLeftOfIt) {
  Desk desk({folder_ / "red.hlod", folder_ / "high.hlod"});
  constexpr int kColumn = 60;
  const Picture swiped = desk.draw(above_plates(), {Split::Kind::kSwipe, kColumn});
  desk.session().looks()[1].is_visible = false;
  const Picture others = desk.draw(above_plates());
  desk.session().looks()[1].is_visible = true;
  desk.session().looks()[0].is_visible = false;
  const Picture last = desk.draw(above_plates());
  for (std::size_t i = 0; i < swiped.pixels.size(); ++i) {
    const bool is_left = static_cast<int>(i % Desk::kWidth) < kColumn;
    ASSERT_EQ(swiped.pixels[i], (is_left ? others : last).pixels[i]) << i;
  }
}

TEST_F(Layered, SideBySideShowsTheSameViewTwice) {
  Desk desk({folder_ / "red.hlod", folder_ / "high.hlod"});
  const Picture both = desk.draw(above_plates(), {Split::Kind::kSideBySide});
  std::size_t red = 0, green = 0;
  for (std::size_t i = 0; i < both.pixels.size(); ++i) {
    const bool is_left = i % Desk::kWidth < Desk::kWidth / 2;
    red += is_left && is_red(both.pixels[i]) ? 1 : 0;
    green += !is_left && is_green(both.pixels[i]) ? 1 : 0;
  }
  EXPECT_EQ(red, both.pixels.size() / 2);
  EXPECT_EQ(green, both.pixels.size() / 2);
}

TEST_F(Layered, ThreeShowThroughInTheirOrderFromTheFirstToTheLast) {
  write_plate(folder_ / "higher.hlod", [](double, double) { return 9.0; }, {30, 30, 200});
  Desk desk({folder_ / "red.hlod", folder_ / "high.hlod", folder_ / "higher.hlod"});
  auto& looks = desk.session().looks();
  const auto alone = [&](std::size_t layer) {
    for (std::size_t i = 0; i < 3; ++i) looks[i].is_visible = i == layer;
    return desk.middle();
  };
  const std::array<Colour, 3> own{alone(0), alone(1), alone(2)};
  for (LayerLook& look : looks) look.is_visible = true;
  looks[1].opacity = 0.6;
  looks[2].opacity = 0.3;
  const Colour mixed = desk.middle();
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(mixed[c], 0.3 * own[2][c] + 0.7 * (0.6 * own[1][c] + 0.4 * own[0][c]), 2.0);
  // What is drawn after what lies above it is hidden by that.
  desk.session().swap_layers(1, 2);
  const Colour other = desk.middle();
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(other[c], 0.3 * own[2][c] + 0.7 * own[0][c], 2.0);
}

TEST_F(Layered, TheSwipeLineIsAtItsColumnInPicturesOfAnyWidth) {
  Desk desk({folder_ / "red.hlod", folder_ / "blue.hlod"});
  for (const int width : {1, 2, 97, 160, 255}) {
    const int height = 120;
    const Target target(width, height, 1);
    for (const double column : {0.0, 1.0, 40.25, 0.5 * width + 0.1, width - 1.0, 1.0 * width}) {
      const Split split{Split::Kind::kSwipe, column};
      desk.session().draw(target.framebuffer(), width, height, above_plates(), 0.0, {}, split);
      const Picture picture = read_picture(target);
      for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        const double middle = double(i % static_cast<std::size_t>(width)) + 0.5;
        EXPECT_TRUE(middle < column ? is_red(picture.pixels[i]) : is_blue(picture.pixels[i]))
            << width << ' ' << column << ' ' << middle;
      }
    }
  }
}

TEST_F(Layered, APixelWhoseMiddleTheSwipeLineMeetsIsOfTheSecondPictureAlone) {
  Desk desk({folder_ / "red.hlod", folder_ / "high.hlod"});
  auto& looks = desk.session().looks();
  // Half transparent, what is drawn twice has a colour of its own.
  looks[0].opacity = looks[1].opacity = 0.5;
  const auto alone = [&](std::size_t layer) {
    looks[1 - layer].is_visible = false;
    auto pixels = desk.draw(above_plates(), {}).pixels;
    looks[1 - layer].is_visible = true;
    return pixels;
  };
  for (const bool has_edges : {false, true}) {
    desk.session().style().has_edges = has_edges;
    const auto first = alone(0), second = alone(1);
    for (const double column : {0.5, 1.5, 79.5, 80.5, Desk::kWidth - 0.5}) {
      const auto swiped = desk.draw(above_plates(), {Split::Kind::kSwipe, column}).pixels;
      for (std::size_t i = 0; i < swiped.size(); ++i) {
        const double middle = double(i % Desk::kWidth) + 0.5;
        ASSERT_EQ(swiped[i], (middle < column ? first : second)[i]) << column << ' ' << middle;
      }
    }
  }
}

TEST_F(Layered, SideBySideOneCameraSeesTheSameTwiceAndNothingBesideThemAtOddWidths) {
  const auto bumps = [](double x, double y) { return 3.0 * std::sin(0.9 * x) * std::cos(0.7 * y); };
  write_plate(folder_ / "one.hlod", bumps, {90, 140, 60});
  write_plate(folder_ / "two.hlod", bumps, {90, 140, 60});
  Desk desk({folder_ / "one.hlod", folder_ / "two.hlod"});
  const Camera camera{plate_corner() + Vec3d{50.0, -30.0, 40.0}, 20.0, -25.0, 50.0};
  for (const int width : {200, 201}) {
    const int height = 90;
    const Target target(width, height, 1);
    const std::array<float, 4> magenta{1.0f, 0.0f, 1.0f, 1.0f};
    glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, magenta.data());
    desk.session().draw(target.framebuffer(), width, height, camera, 0.0, {},
                        {Split::Kind::kSideBySide});
    const Picture both = read_picture(target);
    std::size_t ground = 0, differing = 0;
    for (int y = 0; y < height; ++y) {
      const auto row = both.pixels.begin() + std::ptrdiff_t{y} * width;
      for (int x = 0; x < 100; ++x) {
        // Edges of triangles fall a rounding to this or that side of a pixel's middle.
        for (std::size_t c = 0; c < 3; ++c)
          differing += std::abs(int{row[x][c]} - int{row[x + 100][c]}) > 4 ? 1 : 0;
        ground += row[x][1] > row[x][2] ? 1 : 0;
      }
      if (width == 201) {
        EXPECT_EQ(row[200], (Colour{0, 0, 0}));
      }
    }
    EXPECT_GT(ground, 2000u);
    EXPECT_LE(differing, 3u * 90u) << "of 27000";
  }
}

TEST_F(Layered, AFrozenViewStaysAsItWasChosenWhereverTheCameraGoes) {
  const auto bumps = [](double x, double y) { return 3.0 * std::sin(0.9 * x) * std::cos(0.7 * y); };
  write_plate(folder_ / "bumps.hlod", bumps, {200, 200, 200});
  Desk desk({folder_ / "bumps.hlod"}, 1.0);
  Camera far = above_plates(), near = above_plates();
  far.eye.z += 4000.0;
  near.eye = plate_corner() + Vec3d{10.0, 10.0, 12.0};
  desk.draw(far);
  const auto coarse = desk.session().layers()[0]->chosen();
  const std::uint64_t coarse_triangles = desk.counts().triangles;
  desk.session().is_frozen() = true;
  const Picture frozen = desk.draw(near);
  EXPECT_EQ(desk.session().layers()[0]->chosen(), coarse);
  EXPECT_EQ(desk.counts().triangles, coarse_triangles);
  desk.session().is_frozen() = false;
  const Picture free = desk.draw(near);
  EXPECT_NE(desk.session().layers()[0]->chosen(), coarse);
  EXPECT_GT(desk.counts().triangles, coarse_triangles);
  EXPECT_NE(frozen.pixels, free.pixels);
}

}  // namespace
}  // namespace cornice::viewer
