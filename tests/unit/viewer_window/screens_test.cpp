// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/screens.h"

#include <gtest/gtest.h>

namespace cornice::viewer {
namespace {

TEST(Screens, TheOneWithMostOfTheWindowIsFilled) {
  const std::vector<PixelRectangle> two{{0, 0, 1920, 1080}, {1920, 0, 1280, 1024}};
  EXPECT_EQ(screen_with_most_of({100, 100, 800, 600}, two), 0u);
  EXPECT_EQ(screen_with_most_of({2000, 100, 800, 600}, two), 1u);
  EXPECT_EQ(screen_with_most_of({1620, 100, 800, 600}, two), 1u) << "500 of 800 columns";
  EXPECT_EQ(screen_with_most_of({-5000, 0, 10, 10}, two), 0u) << "on none";
  EXPECT_FALSE(screen_with_most_of({0, 0, 10, 10}, {}));
}

}  // namespace
}  // namespace cornice::viewer
