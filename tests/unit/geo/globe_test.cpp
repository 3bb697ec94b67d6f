// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/globe.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cornice {
namespace {

TEST(Globe, HasTheConvergenceOfTheGrid) {
  // On the central meridian of UTM 32 grid north is true north; 2 degrees east of it at 46.5
  // degrees north it is 2 sin(46.5) = 1.451 degrees off to the east.
  const Globe utm(crs_from_text("EPSG:32632"));
  const auto middle = utm.at({500000.0, 5150000.0, 0.0});
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->longitude_deg, 9.0, 1e-9);
  EXPECT_NEAR(middle->convergence_deg, 0.0, 1e-6);
  const auto east = utm.at({653500.0, 5152000.0, 0.0});
  ASSERT_TRUE(east);
  EXPECT_NEAR(east->convergence_deg,
              (east->longitude_deg - 9.0) * std::sin(east->latitude_deg * 3.14159265358979 / 180.0),
              0.002);
  EXPECT_FALSE(Globe(Crs{}).at({0.0, 0.0, 0.0}));
}

TEST(Globe, GivesThePlaceBackThatItWasAskedFor) {
  const Globe lv95(crs_from_text("EPSG:2056"));
  const Vec3d place{2643500.25, 1158000.5, 0.0};
  const auto there = lv95.at(place);
  ASSERT_TRUE(there);
  EXPECT_NEAR(there->latitude_deg, 46.57, 0.02);
  const auto back = lv95.projected(there->latitude_deg, there->longitude_deg);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->x, place.x, 1e-4);
  EXPECT_NEAR(back->y, place.y, 1e-4);
  EXPECT_FALSE(lv95.projected(91.0, 8.0));
  EXPECT_FALSE(Globe(Crs{}).projected(46.0, 8.0));
}

}  // namespace
}  // namespace cornice
