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
  for (int x = 0; x < kWidth; ++x) {
    std::size_t next = 0;
    for (int y = kHeight - 1; y >= 0 && next < count; --y)
      if (is_near(picture.pixels[static_cast<std::size_t>(y * kWidth + x)],
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
  for (const Shading shading : {Shading::kSlope, Shading::kAspect, Shading::kAltitude,
                                Shading::kSupport, Shading::kSource, Shading::kMorph}) {
    style.shading = shading;
    const auto ramp = ramp_of(style);
    ASSERT_TRUE(ramp);
    const Picture picture = draw([&] { draw_legends(style, false, kWidth); });
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
  const Picture picture = draw([&] { draw_legends(style, true, kWidth); });
  EXPECT_GE(columns_with(picture, difference_ramp(0.8)), 15);
  EXPECT_GE(columns_with(picture, aspect_ramp()), 15);
}

TEST_F(Over, ColoursWithoutARampHaveNoLegend) {
  Style style;
  for (const Shading shading : {Shading::kNatural, Shading::kPlain, Shading::kLevel}) {
    style.shading = shading;
    const Picture picture = draw([&] { draw_legends(style, false, kWidth); });
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
