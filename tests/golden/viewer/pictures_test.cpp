// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures that were looked at, and what is drawn now. README.md says how they are made anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/golden/viewer/stage.h"
#include "tests/support/perceived.h"
#include "tests/support/picture.h"

namespace cornice::viewer {
namespace {

namespace fs = std::filesystem;
using test::Perceived;
using test::perceived_difference;

const fs::path kFolder = fs::path(CORNICE_SOURCE_DIR) / "tests" / "golden" / "viewer";
/// Rounding of another rasteriser stays far below; what a person would call another picture is
/// above one of both (README.md has the numbers).
constexpr double kMeanLimit = 0.3, kP99Limit = 3.0;

std::vector<View> all_views() {
  const double finest = View{}.error_pixels;
  return {{"natural"},
          {"plain", Shading::kPlain},
          {"slope", Shading::kSlope},
          {"aspect", Shading::kAspect},
          {"altitude_contours", Shading::kAltitude, finest, 5.0},
          {"support", Shading::kSupport},
          {"source", Shading::kSource},
          {"colour", Shading::kColour},
          {"level", Shading::kLevel, 6.0},
          {"drape", Shading::kNatural, finest, 0.0, false, true},
          {"side_by_side", Shading::kAltitude, finest, 0.0, true, false, Split::Kind::kSideBySide},
          {"swipe", Shading::kNatural, finest, 0.0, false, true, Split::Kind::kSwipe}};
}

bool is_alike(const Perceived& difference) {
  return difference.mean <= kMeanLimit && difference.p99 <= kP99Limit;
}

class Golden : public testing::Test {
 protected:
  static fs::path file_of(const View& view) { return kFolder / (view.name + ".png"); }

  void expect_as_before(const View& view) {
    const Picture now = stage_.draw(view);
    const Perceived difference = perceived_difference(test::read_png(file_of(view)), now);
    if (is_alike(difference)) return;
    const fs::path got = fs::path(CORNICE_BIN_DIR) / ("golden-" + view.name + ".png");
    write_picture(got, now);
    ADD_FAILURE() << view.name << " differs by " << difference.mean
                  << " on average, 99 of 100 pixels by up to " << difference.p99
                  << " (accepted: " << kMeanLimit << ", " << kP99Limit << "); drawn now: " << got
                  << "; " << kFolder / "README.md"
                  << " says what to do";
  }
  void expect_missed(const View& view, const std::string& what, const Change& change) {
    const Perceived difference =
        perceived_difference(test::read_png(file_of(view)), stage_.draw(view, change));
    EXPECT_FALSE(is_alike(difference)) << view.name << " with " << what << ": mean "
                                       << difference.mean << ", p99 " << difference.p99;
  }

  Stage stage_;
};

TEST_F(Golden, PicturesAreDrawnAsBefore) {
  for (const View& view : all_views()) {
    if (std::getenv("CORNICE_REMAKE_GOLDEN") != nullptr)
      write_picture(file_of(view), stage_.draw(view));
    else
      expect_as_before(view);
  }
}

TEST_F(Golden, PicturesAreRecognisedAfterOtherRounding) {
  // Every channel of every pixel up to one step off, and positions by a hundredth of a pixel.
  for (const View& view : all_views()) {
    Picture now = stage_.draw(view, [](Session&, Camera& camera) { camera.heading_deg += 0.002; });
    std::uint32_t state = 1;
    for (auto& pixel : now.pixels)
      for (std::uint8_t& channel : pixel) {
        state = state * 1664525u + 1013904223u;
        channel = static_cast<std::uint8_t>(
            std::clamp(int{channel} + static_cast<int>((state >> 24) % 3) - 1, 0, 255));
      }
    const Perceived difference = perceived_difference(test::read_png(file_of(view)), now);
    EXPECT_TRUE(is_alike(difference))
        << view.name << ": mean " << difference.mean << ", p99 " << difference.p99;
    EXPECT_GT(difference.mean, 0.0);
  }
}

TEST_F(Golden, PicturesAreMissedWhereTheLightComesFromElsewhere) {
  for (const View& view : all_views())
    expect_missed(view, "the sun 20 degrees farther", [](Session& session, Camera&) {
      session.style().sun = sun_direction(335.0, 45.0);
    });
}

TEST_F(Golden, PicturesAreMissedWhereTheCameraTurns) {
  for (const View& view : all_views())
    expect_missed(view, "the camera turned by half a degree",
                  [](Session&, Camera& camera) { camera.heading_deg += 0.5; });
}

TEST_F(Golden, PicturesAreMissedInOtherColours) {
  for (const View& view : all_views())
    expect_missed(view, "other colours", [](Session& session, Camera&) {
      Style& style = session.style();
      switch (style.shading) {
        case Shading::kNatural:
          style.tree_line_m += 15.0;
          style.snow_line_m -= 15.0;
          style.photo_relief += 0.3;
          break;
        case Shading::kAltitude:
          style.low_m -= 10.0;
          break;
        case Shading::kSupport:
          style.support_high_m *= 1.2;
          break;
        default:
          style.sun_strength *= 0.9;
          style.shading = style.shading == Shading::kPlain ? Shading::kColour : Shading::kPlain;
      }
    });
}

}  // namespace
}  // namespace cornice::viewer
