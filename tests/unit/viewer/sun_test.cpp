// SPDX-License-Identifier: GPL-3.0-or-later
// The sun against two other accounts of it: the worked example of Reda and Andreas, "Solar position
// algorithm for solar radiation applications", Solar Energy 76(5), 2004, and the low-precision
// formulas of the Astronomical Almanac, page C5, good to 0.01 degrees from 1950 to 2050.
#include "terrain-viewer/scene/sun.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace cornice::viewer {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

/// days: from noon of 2000-01-01, UTC.
SunPosition almanac(double days, double latitude_deg, double longitude_deg) {
  const double mean_longitude = 280.460 + 0.9856474 * days;
  const double anomaly = (357.528 + 0.9856003 * days) * kRadians;
  const double longitude =
      (mean_longitude + 1.915 * std::sin(anomaly) + 0.020 * std::sin(2.0 * anomaly)) * kRadians;
  const double obliquity = (23.439 - 0.0000004 * days) * kRadians;
  const double right_ascension =
      std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
  const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));
  const double sidereal_hours = 18.697374558 + 24.06570982441908 * days;
  const double hour_angle = (sidereal_hours * 15.0 + longitude_deg) * kRadians - right_ascension;
  const double latitude = latitude_deg * kRadians;
  const double up = std::sin(latitude) * std::sin(declination) +
                    std::cos(latitude) * std::cos(declination) * std::cos(hour_angle);
  const double north = std::cos(latitude) * std::sin(declination) -
                       std::sin(latitude) * std::cos(declination) * std::cos(hour_angle);
  const double east = -std::cos(declination) * std::sin(hour_angle);
  const double azimuth = std::atan2(east, north) / kRadians;
  return {azimuth < 0.0 ? azimuth + 360.0 : azimuth, std::asin(up) / kRadians};
}

TEST(SunPosition, IsThatOfAPublishedExample) {
  const auto sun = sun_at("2003-10-17T19:30:30Z", 39.742476, -105.1786);
  ASSERT_TRUE(sun);
  EXPECT_NEAR(sun->azimuth_deg, 194.34024, 0.01);
  EXPECT_NEAR(sun->elevation_deg, 39.872046, 0.01) << "without refraction";
}

TEST(SunPosition, IsThatOfTheAlmanacInBothHemispheresAndAllSeasons) {
  struct Day {
    const char* date;
    double days;  ///< to its midnight
  };
  const std::array<Day, 4> dates{{{"2026-03-20", 9574.5},
                                  {"2026-06-21", 9667.5},
                                  {"2026-10-05", 9773.5},
                                  {"2026-12-21", 9850.5}}};
  const std::array<std::array<double, 2>, 4> places{
      {{46.0, 7.66}, {69.6, 18.9}, {-46.5, -73.2}, {0.1, 32.0}}};
  int days_and_nights = 0;
  for (const Day& day : dates) {
    for (const auto& [latitude, longitude] : places) {
      for (int hour = 0; hour < 24; hour += 3) {
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%sT%02d:17:00Z", day.date, hour);
        const auto sun = sun_at(text.data(), latitude, longitude);
        ASSERT_TRUE(sun);
        const SunPosition other =
            almanac(day.days + (hour + 17.0 / 60.0) / 24.0, latitude, longitude);
        EXPECT_NEAR(sun->elevation_deg, other.elevation_deg, 0.03) << text.data() << latitude;
        // Degrees of azimuth are short near the zenith.
        const double apart = std::remainder(sun->azimuth_deg - other.azimuth_deg, 360.0) *
                             std::cos(other.elevation_deg * kRadians);
        EXPECT_NEAR(apart, 0.0, 0.03) << text.data() << latitude;
        days_and_nights |= other.elevation_deg > 5.0 ? 1 : other.elevation_deg < -5.0 ? 2 : 0;
      }
    }
  }
  EXPECT_EQ(days_and_nights, 3);
}

TEST(Daylight, FadesFromDayToNightWithoutAJump) {
  Daylight before = daylight(-1.0);
  EXPECT_EQ(before.sun, 0.0);
  EXPECT_GT(before.sky.z, 0.05) << "there is something to be seen at night";
  for (double elevation = -89.5; elevation <= 90.0; elevation += 0.5) {
    const Daylight now = daylight(std::sin(elevation * kRadians));
    EXPECT_GE(now.sun, before.sun) << elevation;
    EXPECT_GE(now.sky.z, before.sky.z) << elevation;
    EXPECT_GE(now.haze.z, before.haze.z) << elevation;
    EXPECT_GE(now.sun_colour.z, before.sun_colour.z - 1e-12) << elevation << ": bluer when higher";
    EXPECT_EQ(now.sun_colour.x, 1.0);
    EXPECT_NEAR(now.warmth, before.warmth, 0.1) << elevation;
    EXPECT_LT(norm(now.sky - before.sky), 0.08) << elevation;
    before = now;
  }
  EXPECT_EQ(before.sun, 1.0);
  EXPECT_EQ(before.warmth, 0.0);
}

}  // namespace
}  // namespace cornice::viewer
