// SPDX-License-Identifier: GPL-3.0-or-later
// What changes from frame to frame in a slow flight: what the eye's motion changes, and no more.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "tests/property/viewer/crater.h"
#include "tests/support/temporary_folder.h"

namespace cornice::viewer {
namespace {

constexpr int kWidth = 400, kHeight = 304, kBlock = 8;
/// Coarse, so that morphs are large.
constexpr double kErrorPixels = 8.47;
constexpr int kSteps = 300;
/// Mean brightness that a block may change by from step to step, more than it does with the finest
/// mesh alone. Morphing is continuous: it changes less the shorter the step, a pop does not.
constexpr double kBound = 4.0;

/// Mean brightness of blocks of 8 x 8 pixels: a pop changes the mean of a block at once, noise of
/// rasterising does not.
std::vector<double> blocks_of(const Picture& picture) {
  std::vector<double> blocks(std::size_t(kWidth / kBlock) * (kHeight / kBlock), 0.0);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (const std::uint8_t channel : picture.pixels[std::size_t(y) * kWidth + std::size_t(x)])
        blocks[std::size_t(y / kBlock) * (kWidth / kBlock) + std::size_t(x / kBlock)] +=
            channel / (3.0 * kBlock * kBlock);
  return blocks;
}

double largest_change(const Picture& before, const Picture& after) {
  const std::vector<double> a = blocks_of(before), b = blocks_of(after);
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// High over the ground and looking down on where levels change; 4 cm a step.
Camera slow_camera(int step) {
  Camera camera = crater_camera(0.12);
  camera.eye += Vec3d{-0.03 * step, -0.025 * step, 25.0};
  camera.heading_deg = 200.0;
  camera.pitch_deg = -50.0;
  return camera;
}

struct Step {
  Camera camera;
  DrawList list;
  std::vector<std::uint32_t> cells;
};

TEST(Popping, IsNotSeenInASlowFlightAndIsWhereVerticesDoNotMorph) {
  const test::TemporaryFolder folder;
  write_crater(folder / "crater.hlod");
  CraterStudio studio(folder / "crater.hlod", kWidth, kHeight, {});
  const auto settled = [&](int step, double error_pixels) {
    const Camera camera = slow_camera(step);
    EXPECT_TRUE(studio.settle(camera, error_pixels));
    auto cells = studio.layer().chosen();
    std::sort(cells.begin(), cells.end());
    return Step{camera, studio.layer().list(), cells};
  };
  const auto change = [&](const Step& a, const Step& b) {
    return largest_change(studio.draw(a.list, a.camera), studio.draw(b.list, b.camera));
  };
  double morphed = 0.0, unmorphed = 0.0, finest = 0.0;
  int changes = 0;
  Step before = settled(0, kErrorPixels);
  for (int step = 1; step < kSteps; ++step) {
    Step now = settled(step, kErrorPixels);
    // Where other cells are drawn, and now and then, to see what the motion alone changes.
    const bool has_changed = now.cells != before.cells;
    changes += has_changed ? 1 : 0;
    if (has_changed || step % 50 == 0) {
      morphed = std::max(morphed, change(before, now));
      before.list = without_morphing(before.list);
      Step own = now;
      own.list = without_morphing(now.list);
      unmorphed = std::max(unmorphed, change(before, own));
      finest = std::max(finest, change(settled(step - 1, 0.01), settled(step, 0.01)));
    }
    before = std::move(now);
  }
  EXPECT_GE(changes, 5) << "too few changes of level to tell";
  EXPECT_LE(morphed, finest + kBound);
  EXPECT_GT(unmorphed, finest + kBound);
}

}  // namespace
}  // namespace cornice::viewer
