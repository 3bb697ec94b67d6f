// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "terrain-viewer/app/scene_setup.h"
#include "terrain-viewer/scene/ramp.h"
#include "terrain-viewer/scene/sun.h"

namespace cornice::viewer {
namespace {

TEST(Sun, StandsInTheSouthAtNoonAsHighAsTheSeasonSays) {
  // Greenwich, summer solstice 2026: 90 - 51.4779 + 23.437 degrees at true noon, 12:02 UTC.
  const auto noon = sun_at("2026-06-21T12:02:00Z", 51.4779, 0.0);
  ASSERT_TRUE(noon);
  EXPECT_NEAR(noon->elevation_deg, 61.96, 0.05);
  EXPECT_NEAR(noon->azimuth_deg, 180.0, 1.0);
  const auto morning = sun_at("2026-06-21T06:00:00Z", 51.4779, 0.0);
  ASSERT_TRUE(morning);
  EXPECT_LT(morning->azimuth_deg, 90.0);
  EXPECT_GT(morning->elevation_deg, 0.0);
}

TEST(Sun, IsUnderTheHorizonAtMidnight) {
  const auto night = sun_at("2026-12-21T00:00:00Z", 46.5, 8.0);
  ASSERT_TRUE(night);
  EXPECT_LT(night->elevation_deg, -60.0);
}

TEST(Sun, TakesNoTextForATimeThatIsNone) {
  for (const char* text : {"", "noon", "2026-06-21", "2026-13-01T00:00:00Z", "2026-06-21T12:00:00",
                           "2026-06-21T25:00:00Z", "2026-06-21T12:00:00Zz"})
    EXPECT_FALSE(sun_at(text, 46.0, 8.0)) << text;
}

TEST(Light, OfATimeIsTheSunsOverThePlaceByGridNorth) {
  Options options;
  options.time = "2026-06-21T12:02:00Z";
  const Light light = light_of(options);
  EXPECT_TRUE(light.is_of_time);
  EXPECT_EQ(light.month, 6);
  EXPECT_EQ(light.day, 21);
  // Grid north two degrees east of true north: the sun is seen two degrees to the left.
  const Vec3d sun = towards_sun(light, GlobePosition{51.4779, 0.0, 2.0});
  EXPECT_NEAR(std::asin(sun.z) * 57.29577951, 61.96, 0.05);
  EXPECT_NEAR(std::atan2(sun.x, sun.y) * 57.29577951, 178.0, 1.0);
  Light later = light;
  later.hour += 1.0;
  EXPECT_LT(towards_sun(later, GlobePosition{51.4779, 0.0, 2.0}).x, sun.x) << "goes west";
}

TEST(Light, IsAsToldWithoutATimeOrAPlace) {
  Options options;
  options.sun_azimuth_deg = 90.0;
  options.sun_elevation_deg = 30.0;
  const Vec3d east = towards_sun(light_of(options), GlobePosition{46.0, 8.0, 0.0});
  EXPECT_NEAR(east.x, std::cos(30.0 / 57.29577951), 1e-6);
  EXPECT_NEAR(east.z, 0.5, 1e-6);
  options.time = "2026-12-21T08:00:00Z";
  const Vec3d nowhere = towards_sun(light_of(options), std::nullopt);
  EXPECT_NEAR(norm(nowhere - east), 0.0, 1e-9);
  options.time = "noon";
  EXPECT_THROW(light_of(options), UsageError);
}

TEST(Ramp, HasItsColoursAtItsStopsAndBetweenThem) {
  const Ramp ramp = altitude_ramp(500.0, 4100.0);
  EXPECT_EQ(ramp.low(), 500.0);
  EXPECT_EQ(ramp.high(), 4100.0);
  for (const Ramp::Stop& stop : ramp.stops) EXPECT_EQ(ramp.at(stop.value), stop.colour);
  EXPECT_EQ(ramp.at(-1e9), ramp.stops.front().colour);
  EXPECT_EQ(ramp.at(1e9), ramp.stops.back().colour);
  const Colour between = ramp.at(0.5 * (ramp.stops[1].value + ramp.stops[2].value));
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_GE(between[c], std::min(ramp.stops[1].colour[c], ramp.stops[2].colour[c]));
    EXPECT_LE(between[c], std::max(ramp.stops[1].colour[c], ramp.stops[2].colour[c]));
  }
}

TEST(Ramp, OfSlopesHasTheClassesOfAvalancheMaps) {
  const Ramp ramp = slope_ramp();
  EXPECT_EQ(ramp.at(29.9), ramp.at(0.0));
  EXPECT_NE(ramp.at(30.1), ramp.at(29.9));
  EXPECT_EQ(ramp.at(30.1), ramp.at(34.9));
  EXPECT_NE(ramp.at(34.9), ramp.at(35.1));
  EXPECT_NE(ramp.at(39.9), ramp.at(40.1));
}

TEST(Ramp, OfAspectsCloses) {
  const Ramp ramp = aspect_ramp();
  EXPECT_EQ(ramp.at(0.0), ramp.at(360.0));
}

TEST(Ramp, TableIsTheRampInTheMiddleOfItsSteps) {
  const Ramp ramp = difference_ramp(2.0);
  const auto table = ramp.table(64);
  ASSERT_EQ(table.size(), 64u);
  EXPECT_EQ(table[0], ramp.at(-2.0 + 4.0 * 0.5 / 64.0));
  EXPECT_EQ(table[63], ramp.at(2.0 - 4.0 * 0.5 / 64.0));
}

}  // namespace
}  // namespace cornice::viewer
