// SPDX-License-Identifier: GPL-3.0-or-later
// The diverging scheme RdBu: Brewer, Harrower 2003, "ColorBrewer.org: an online tool for selecting
// colour schemes for maps".
#include "stages/compare/colours.h"

#include <algorithm>
#include <cmath>

namespace cornice::compare {

Rgb difference_colour(double difference_m, double range_m) {
  if (std::isnan(difference_m)) return kUnknownColour;
  constexpr std::array<std::array<double, 3>, 7> kStops{{{178, 24, 43},
                                                         {239, 138, 98},
                                                         {253, 219, 199},
                                                         {247, 247, 247},
                                                         {209, 229, 240},
                                                         {103, 169, 207},
                                                         {33, 102, 172}}};
  const double place = std::clamp(0.5 + 0.5 * difference_m / range_m, 0.0, 1.0) * 6.0;
  const auto below = std::min<std::size_t>(static_cast<std::size_t>(place), 5);
  const double part = place - static_cast<double>(below);
  Rgb colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    colour[k] = static_cast<std::uint8_t>(
        std::lround((1.0 - part) * kStops[below][k] + part * kStops[below + 1][k]));
  }
  return colour;
}

Rgb lit(Rgb colour, double light) {
  for (std::uint8_t& channel : colour) {
    channel = static_cast<std::uint8_t>(std::lround(std::clamp(light * channel, 0.0, 255.0)));
  }
  return colour;
}

}  // namespace cornice::compare
