// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/scene/sun.h"

#include <libnova/julian_day.h>
#include <libnova/ln_types.h>
#include <libnova/solar.h>
#include <libnova/transform.h>

#include <cmath>
#include <cstdio>

namespace cornice::viewer {

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
  ln_equ_posn equatorial{};
  ln_get_solar_equ_coords(day, &equatorial);
  ln_lnlat_posn observer{longitude_deg, latitude_deg};
  ln_hrz_posn horizontal{};
  ln_get_hrz_from_equ(&equatorial, &observer, day, &horizontal);
  // libnova counts azimuths from the south.
  return SunPosition{std::fmod(horizontal.az + 180.0, 360.0), horizontal.alt};
}

}  // namespace cornice::viewer
