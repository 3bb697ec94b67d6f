// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/transform.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cornice {
namespace {

TEST(Transformed, ShiftsTheDatum) {
  // The old observatory of Bern, 46 57' 08.66" N 7 26' 22.50" E on CH1903+, and in WGS 84.
  const Crs lv95 = crs_from_text("EPSG:2056"), wgs84 = crs_from_text("EPSG:4326");
  const auto there = transformed({2'600'000.0, 1'200'000.0, 543.0}, lv95, wgs84);
  ASSERT_TRUE(there);
  EXPECT_NEAR(there->x, 7.438632, 2e-5);
  EXPECT_NEAR(there->y, 46.951083, 2e-5);
  EXPECT_EQ(there->z, 543.0);
  const auto back = transformed(*there, wgs84, lv95);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->x, 2'600'000.0, 0.01);
  EXPECT_NEAR(back->y, 1'200'000.0, 0.01);
}

TEST(Transformed, LeavesAPlaceInItsOwnSystemWhereItIs) {
  const Crs lambert = crs_from_text("EPSG:2154+5720");
  const auto same =
      transformed({998'250.5, 6'536'150.25, 1.0}, lambert, crs_from_text("EPSG:2154"));
  ASSERT_TRUE(same);
  EXPECT_NEAR(same->x, 998'250.5, 1e-6);
  EXPECT_NEAR(same->y, 6'536'150.25, 1e-6);
}

TEST(Transformed, IsNothingWithoutASystem) {
  const Crs lv95 = crs_from_text("EPSG:2056");
  EXPECT_FALSE(transformed({2'600'000.0, 1'200'000.0, 0.0}, lv95, Crs{}));
  EXPECT_FALSE(transformed({2'600'000.0, 1'200'000.0, 0.0}, Crs{}, lv95));
}

}  // namespace
}  // namespace cornice
