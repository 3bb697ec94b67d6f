// SPDX-License-Identifier: GPL-3.0-or-later
// Air mass: Kasten and Young, "Revised optical air mass tables and approximation formula", Applied
// Optics 28(22), 1989.
#include "terrain-viewer/scene/sun.h"

#include <libnova/julian_day.h>
#include <libnova/ln_types.h>
#include <libnova/precession.h>
#include <libnova/solar.h>
#include <libnova/transform.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace cornice::viewer {
namespace {

/// 0 below `low`, 1 above `high`, smooth between.
double rise(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Air that light of a sun so high comes through; 1 from the zenith.
double air_mass(double elevation_deg) {
  // Lower, it is red as glowing iron, which nobody takes for light on a map.
  constexpr double kLowestDeg = 4.0;
  const double e = std::max(elevation_deg, kLowestDeg);
  return 1.0 / (std::sin(e * std::numbers::pi / 180.0) + 0.50572 * std::pow(e + 6.07995, -1.6364));
}

/// Colour of the sun's light: white-yellow at 45 degrees, orange at the horizon; half as much as it
/// is, because the eye gets used to it.
Vec3d sunlight(double elevation_deg) {
  // Of molecules, for one air mass: red, green, blue.
  const Vec3d depth{0.046, 0.108, 0.265};
  const double more = 0.5 * (air_mass(elevation_deg) - air_mass(45.0));
  const auto through = [&](double of) { return std::exp(-more * (of - depth.x)); };
  return {1.0, 0.96 * through(depth.y), 0.88 * through(depth.z)};
}

}  // namespace

std::optional<SunPosition> sun_at(const std::string& time, double latitude_deg,
                                  double longitude_deg) {
  ln_date date{};
  char end = 0, rest = 0;
  const int read =
      std::sscanf(time.c_str(), "%4d-%2d-%2dT%2d:%2d:%lf%c%c", &date.years, &date.months,
                  &date.days, &date.hours, &date.minutes, &date.seconds, &end, &rest);
  const bool sane = read == 7 && end == 'Z' && date.months >= 1 && date.months <= 12 &&
                    date.days >= 1 && date.days <= 31 && date.hours >= 0 && date.hours < 24 &&
                    date.minutes >= 0 && date.minutes < 60 && date.seconds >= 0.0 &&
                    date.seconds < 61.0;
  if (!sane) return std::nullopt;
  const double day = ln_get_julian_day(&date);
  // By the equinox of the year 2000, since when it has gone a third of a degree.
  ln_equ_posn of_2000{}, equatorial{};
  ln_get_solar_equ_coords(day, &of_2000);
  ln_get_equ_prec(&of_2000, day, &equatorial);
  ln_lnlat_posn observer{longitude_deg, latitude_deg};
  ln_hrz_posn horizontal{};
  ln_get_hrz_from_equ(&equatorial, &observer, day, &horizontal);
  // libnova counts azimuths from the south.
  return SunPosition{std::fmod(horizontal.az + 180.0, 360.0), horizontal.alt};
}

Daylight daylight(double sine_of_elevation) {
  const double sine = std::clamp(sine_of_elevation, -1.0, 1.0);
  const double elevation_deg = std::asin(sine) * 180.0 / std::numbers::pi;
  // The stars come out 12 degrees below the horizon; maps are read by the rest.
  constexpr double kNight = 0.12;
  const double brightness = std::lerp(kNight, 1.0, rise(-12.0, 6.0, elevation_deg));
  Daylight day;
  day.sun = std::clamp(sine * 4.0 + 0.15, 0.0, 1.0);
  day.sun_colour = sunlight(elevation_deg);
  day.sky = brightness * Vec3d{0.45, 0.62, 0.92};
  day.ground = brightness * Vec3d{0.42, 0.38, 0.32};
  day.haze = brightness * Vec3d{0.66, 0.76, 0.88};
  day.warmth = 0.8 * rise(-10.0, -1.0, elevation_deg) * (1.0 - rise(2.0, 14.0, elevation_deg));
  return day;
}

}  // namespace cornice::viewer
