// SPDX-License-Identifier: GPL-3.0-or-later
// When another frame would be the same picture.
#include <gtest/gtest.h>

#include <cmath>

#include "terrain-viewer/render/offscreen_context.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/viewer_session/plates.h"

namespace cornice::viewer {
namespace {

constexpr int kMostFrames = 5000;

class Rest : public testing::Test {
 protected:
  Rest() {
    write_plate(folder_ / "bumps.hlod",
                [](double x, double y) { return 3.0 * std::sin(0.9 * x) * std::cos(0.7 * y); },
                {200, 200, 200});
  }
  static Camera from_aside(double height) {
    return {plate_corner() + Vec3d{50.0, -40.0, height}, 0.0, -30.0, 50.0};
  }
  /// Draws frames of so many seconds until the next would be the same; how many.
  static int rest(Desk& desk, const Camera& camera, double seconds) {
    for (int frame = 1; frame < kMostFrames; ++frame)
      if (step(desk, camera, seconds).is_still) return frame;
    ADD_FAILURE() << "never comes to rest";
    return kMostFrames;
  }
  static FrameCounts step(Desk& desk, const Camera& camera, double seconds) {
    return desk.session().draw(desk.target().framebuffer(), Desk::kWidth, Desk::kHeight, camera,
                               seconds, {});
  }

  test::TemporaryFolder folder_;
  OffscreenContext context_;
};

TEST_F(Rest, IsWithThePictureThatWaitingForAllGivesHoweverShortFramesAre) {
  for (const double seconds : {0.016, 0.1}) {
    Desk desk({folder_ / "bumps.hlod"}, 1.5), other({folder_ / "bumps.hlod"}, 1.5);
    for (const double height : {40.0, 400.0}) {
      EXPECT_GT(rest(desk, from_aside(height), seconds), 2);
      const Picture shown = read_picture(desk.target());
      const auto& bands = desk.session().layers()[0]->list().bands;
      const Picture whole = other.draw(from_aside(height));
      EXPECT_EQ(shown.pixels, whole.pixels) << seconds << ' ' << height;
      const auto& wanted = other.session().layers()[0]->list().bands;
      ASSERT_EQ(bands.size(), wanted.size());
      for (std::size_t level = 0; level < bands.size(); ++level)
        EXPECT_EQ(bands[level].end, wanted[level].end) << seconds << ' ' << height << ' ' << level;
    }
  }
}

TEST_F(Rest, EndsWithTheCameraTheErrorTheLookAndTheLayers) {
  write_plate(folder_ / "flat.hlod", [](double, double) { return -20.0; }, {200, 30, 30});
  Desk desk({folder_ / "bumps.hlod", folder_ / "flat.hlod"});
  Session& session = desk.session();
  Camera camera = from_aside(60.0);
  const auto expect_moves = [&](const char* what) {
    EXPECT_FALSE(step(desk, camera, 0.1).is_still) << what;
    rest(desk, camera, 0.1);
    EXPECT_TRUE(step(desk, camera, 0.1).is_still) << what;
  };
  expect_moves("opened");
  camera.heading_deg += 0.01;
  expect_moves("turned");
  session.error_pixels() *= 1.5;
  expect_moves("error");
  session.style().shading = Shading::kSlope;
  expect_moves("shading");
  session.looks()[1].is_visible = false;
  expect_moves("layer");
  session.is_frozen() = true;
  expect_moves("frozen");
}

TEST_F(Rest, WaitsForTheTimeOfAFrameToBeFollowed) {
  Desk desk({folder_ / "bumps.hlod"}, 1.0);
  desk.session().frame_ms() = 1e6;
  const int frames = rest(desk, from_aside(60.0), 0.1);
  EXPECT_GT(frames * 0.1, 1.0) << "two medians of half a second";
  // A picture that takes longer than anybody wants gives all its detail up before it rests.
  desk.session().frame_ms() = 1e-6;
  rest(desk, from_aside(60.0), 0.1);
  EXPECT_NEAR(step(desk, from_aside(60.0), 0.1).error_pixels, 1.0 / FrameBudget::kLeast, 1e-9);
}

TEST_F(Rest, FramesAfterPausesSayNothingAboutDetail) {
  Desk desk({folder_ / "bumps.hlod"}, 1.0);
  rest(desk, from_aside(60.0), 0.1);
  desk.session().frame_ms() = 1e-6;
  for (int i = 0; i < 20; ++i) {
    desk.session().pause();
    EXPECT_EQ(step(desk, from_aside(60.0), 0.1).error_pixels, 1.0);
  }
}

}  // namespace
}  // namespace cornice::viewer
