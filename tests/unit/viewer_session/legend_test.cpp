// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/legend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "terrain-viewer/app/overlay.h"
#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/app/scale_bar.h"
#include "terrain-viewer/render/offscreen_context.h"

namespace cornice::viewer {
namespace {

constexpr int kWidth = 640, kHeight = 480;

class Over : public testing::Test {
 protected:
  Over() : target_(kWidth, kHeight, 1) {}
  /// Panels over black.
  Picture draw(const std::function<void()>& panels) {
    const std::array<float, 4> black{0.0f, 0.0f, 0.0f, 1.0f};
    glClearNamedFramebufferfv(target_.framebuffer(), GL_COLOR, 0, black.data());
    overlay_.draw(target_, panels);
    return read_picture(target_);
  }
  static Colour at(const Picture& picture, int x, int y) {
    return picture.pixels[static_cast<std::size_t>(y * kWidth + x)];
  }

  OffscreenContext context_;
  Overlay overlay_;
  Target target_;
};

bool is_near(Colour a, Colour b) {
  for (std::size_t c = 0; c < 3; ++c)
    if (std::abs(int{a[c]} - int{b[c]}) > 4) return false;
  return true;
}

/// How many columns show the colours of all stops one over the other, the lowest at the bottom.
int columns_with(const Picture& picture, const Ramp& ramp) {
  const std::size_t count = ramp.stops.size() - (ramp.is_stepped ? 1 : 0);
  int columns = 0;
  for (int x = 0; x < picture.width; ++x) {
    std::size_t next = 0;
    for (int y = picture.height - 1; y >= 0 && next < count; --y)
      if (is_near(picture.pixels[static_cast<std::size_t>(y * picture.width + x)],
                  ramp.stops[next].colour))
        ++next;
    columns += next == count ? 1 : 0;
  }
  return columns;
}

TEST_F(Over, LegendsShowTheColoursOfTheirRampInOrder) {
  Style style;
  style.low_m = 1200.0;
  style.high_m = 3400.0;
  for (const Shading shading :
       {Shading::kSlope, Shading::kAspect, Shading::kAltitude, Shading::kSupport, Shading::kSource,
        Shading::kMorph, Shading::kLevel, Shading::kOverdraw}) {
    style.shading = shading;
    const auto ramp = legend_of(style, 5);
    ASSERT_TRUE(ramp);
    const Picture picture = draw([&] { draw_legends(style, false, 5, kWidth); });
    EXPECT_GE(columns_with(picture, *ramp), 15) << ramp->title;
    for (const Shading other : {Shading::kSlope, Shading::kAspect, Shading::kAltitude}) {
      if (other == shading) continue;
      Style wrong = style;
      wrong.shading = other;
      EXPECT_EQ(columns_with(picture, *ramp_of(wrong)), 0) << ramp->title << " is another's";
    }
  }
}

TEST_F(Over, ADifferenceMapHasItsLegendAboveTheGrounds) {
  Style style;
  style.shading = Shading::kAspect;
  style.difference_high_m = 0.8;
  const Picture picture = draw([&] { draw_legends(style, true, 5, kWidth); });
  EXPECT_GE(columns_with(picture, difference_ramp(0.8)), 15);
  EXPECT_GE(columns_with(picture, aspect_ramp()), 15);
}

TEST_F(Over, TwoLegendsLieSideBySideWhereThePictureIsTooLowForBoth) {
  Style style;
  style.shading = Shading::kSlope;
  const Target low(kWidth, 250, 1);
  const std::array<float, 4> black{0.0f, 0.0f, 0.0f, 1.0f};
  glClearNamedFramebufferfv(low.framebuffer(), GL_COLOR, 0, black.data());
  overlay_.draw(low, [&] { draw_legends(style, true, 5, kWidth); });
  const Picture picture = read_picture(low);
  EXPECT_GE(columns_with(picture, difference_ramp(style.difference_high_m)), 15);
  EXPECT_GE(columns_with(picture, slope_ramp()), 15);
}

TEST(LargeOverlay, HasLegendsThatAreAsManyTimesLarger) {
  const OffscreenContext context;
  Style style;
  style.shading = Shading::kSlope;
  std::vector<int> columns;
  for (const int scale : {1, 2, 3}) {
    Overlay overlay(scale);
    const Target target(scale * kWidth, scale * kHeight, 1);
    const std::array<float, 4> black{0.0f, 0.0f, 0.0f, 1.0f};
    glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, black.data());
    overlay.draw(target, [&] { draw_legends(style, false, 5, kWidth); });
    columns.push_back(columns_with(read_picture(target), slope_ramp()));
  }
  EXPECT_NEAR(columns[1], 2 * columns[0], 1);
  EXPECT_NEAR(columns[2], 3 * columns[0], 1);
}

TEST_F(Over, AWordIsWrittenBesideItsClassAndThePanelIsAsWideAsIt) {
  Ramp ramp{"A", "", {{0.0, {255, 0, 0}, ""}, {1.0, {0, 255, 0}, ""}, {2.0, {0, 0, 255}}}, true};
  // Rows of the upper class's middle that have anything white.
  const auto white = [&] {
    const Picture picture = draw([&] { draw_legend(ramp, kWidth - 12.0f, 12.0f); });
    int top = kHeight, bottom = 0, count = 0, right = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Colour c = at(picture, x, y);
        if (c == Colour{0, 255, 0}) top = std::min(top, y), bottom = y;
        if (c == Colour{255, 255, 255}) right = x;
      }
    }
    for (int y = (2 * top + bottom) / 3; y < (top + 2 * bottom) / 3; ++y)
      for (int x = 0; x < kWidth; ++x) count += at(picture, x, y) == Colour{255, 255, 255};
    EXPECT_LE(right, kWidth - 12);
    return count;
  };
  EXPECT_EQ(white(), 0) << "numbers are at the ends of classes";
  ramp.stops[1].label = "a rather long word, of an elevation model";
  EXPECT_GT(white(), 50);
}

TEST_F(Over, ColoursWithoutARampHaveNoLegend) {
  Style style;
  for (const Shading shading : {Shading::kNatural, Shading::kPlain, Shading::kNormal}) {
    style.shading = shading;
    const Picture picture = draw([&] { draw_legends(style, false, 5, kWidth); });
    EXPECT_TRUE(std::all_of(picture.pixels.begin(), picture.pixels.end(), [](const Colour& c) {
      return c == Colour{0, 0, 0};
    }));
  }
}

TEST_F(Over, TheScaleBarIsDrawnAsLongAsItSaysAndWhereItsPlaceIs) {
  const Camera camera{{0.0, 0.0, 1000.0}, 30.0, -40.0, 50.0};
  for (const Taken taken : {Taken{300.0f, 420.0f}, Taken{600.0f, 400.0f}}) {
    for (const double depth : {37.0, 600.0, 5000.0}) {
      const Picture picture =
          draw([&] { draw_scale_and_north(camera, kWidth, kHeight, depth, taken); });
      const ScaleBar bar = scale_bar(camera, kHeight, depth, 180.0);
      const auto place = scale_place(kWidth, kHeight, float(bar.pixels), taken.right, taken.top);
      const int y = static_cast<int>(place.low) - 2;
      int white = 0;
      for (int x = 0; x < kWidth; ++x) {
        if (!is_near(at(picture, x, y), {255, 255, 255})) continue;
        ++white;
        EXPECT_TRUE(float(x) > taken.right || float(y) < taken.top) << "over the read-out";
      }
      EXPECT_NEAR(white, bar.pixels, 1.5) << depth;
    }
  }
}

}  // namespace
}  // namespace cornice::viewer
