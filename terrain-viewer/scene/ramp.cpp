// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/scene/ramp.h"

#include <algorithm>
#include <cmath>

namespace cornice::viewer {
namespace {

Colour blend(Colour a, Colour b, double t) {
  Colour c{};
  for (std::size_t i = 0; i < 3; ++i)
    c[i] = static_cast<std::uint8_t>(std::lround(std::lerp(double(a[i]), double(b[i]), t)));
  return c;
}

}  // namespace

Colour Ramp::at(double value) const {
  const auto next = std::upper_bound(stops.begin(), stops.end(), value,
                                     [](double v, const Stop& stop) { return v < stop.value; });
  if (next == stops.begin()) return stops.front().colour;
  const Stop& before = *(next - 1);
  if (next == stops.end() || is_stepped) return before.colour;
  return blend(before.colour, next->colour, (value - before.value) / (next->value - before.value));
}

std::vector<Colour> Ramp::table(std::size_t count) const {
  std::vector<Colour> colours(count);
  for (std::size_t i = 0; i < count; ++i)
    colours[i] = at(low() + (high() - low()) * (double(i) + 0.5) / double(count));
  return colours;
}

Ramp slope_ramp() {
  return {"Slope",
          "degrees",
          {{0.0, {236, 240, 232}},
           {30.0, {250, 230, 80}},
           {35.0, {244, 150, 50}},
           {40.0, {220, 60, 50}},
           {45.0, {150, 60, 150}},
           {60.0, {80, 50, 120}},
           {90.0, {20, 20, 20}, "overhang"},
           {91.0, {20, 20, 20}}},
          true};
}

Ramp aspect_ramp() {
  return {"Aspect",
          "degrees from north",
          {{0.0, {70, 90, 190}},
           {60.0, {60, 170, 190}},
           {120.0, {120, 200, 90}},
           {180.0, {245, 210, 80}},
           {240.0, {235, 120, 70}},
           {300.0, {170, 80, 160}},
           {360.0, {70, 90, 190}}},
          false};
}

Ramp altitude_ramp(double low_m, double high_m) {
  const std::array<Colour, 7> colours{{{70, 130, 90},
                                       {140, 175, 105},
                                       {215, 205, 140},
                                       {190, 150, 105},
                                       {150, 120, 110},
                                       {190, 185, 190},
                                       {250, 250, 252}}};
  Ramp ramp{"Altitude", "m", {}, false};
  for (std::size_t i = 0; i < colours.size(); ++i)
    ramp.stops.push_back(
        {low_m + (high_m - low_m) * double(i) / double(colours.size() - 1), colours[i]});
  return ramp;
}

Ramp support_ramp(double high_m) {
  return {"Distance to the nearest measured point",
          "m",
          {{0.0, {245, 245, 240}},
           {0.2 * high_m, {170, 200, 225}},
           {0.5 * high_m, {245, 190, 90}},
           {high_m, {200, 40, 40}}},
          false};
}

Ramp difference_ramp(double high_m) {
  return {"Difference",
          "m",
          {{-high_m, {40, 70, 160}},
           {-0.5 * high_m, {120, 165, 215}},
           {0.0, {245, 245, 242}},
           {0.5 * high_m, {230, 140, 110}},
           {high_m, {165, 25, 40}}},
          false};
}

Ramp source_ramp() {
  return {"Source",
          "",
          {{0.0, {235, 235, 228}, "measured"},
           {1.0, {240, 160, 60}, "bridged"},
           {2.0, {90, 130, 200}, "elevation model"},
           {3.0, {90, 130, 200}}},
          true};
}

Ramp morph_ramp() {
  return {"Morph: 0 parent, 1 itself", "", {{0.0, {60, 60, 150}}, {1.0, {250, 235, 160}}}, false};
}

Ramp overdraw_ramp() {
  return {"Drawn in a pixel",
          "times",
          {{0.0, {51, 115, 64}, "0"},
           {1.0, {41, 64, 115}, "1"},
           {2.0, {89, 128, 204}, "2"},
           {3.0, {242, 217, 89}, "3"},
           {4.0, {232, 176, 74}, "4"},
           {5.0, {222, 135, 59}, "5"},
           {6.0, {212, 94, 43}, "6"},
           {7.0, {202, 54, 28}, "7"},
           {8.0, {191, 13, 13}, "8 or more"},
           {9.0, {191, 13, 13}}},
          true};
}

Colour level_colour(int level) {
  constexpr std::array<Colour, 8> kColours{{{215, 90, 80},
                                            {235, 165, 75},
                                            {225, 215, 95},
                                            {120, 185, 95},
                                            {85, 175, 170},
                                            {85, 130, 200},
                                            {140, 105, 190},
                                            {205, 120, 170}}};
  return kColours[static_cast<std::size_t>(level) % kColours.size()];
}

Colour cell_colour(int level, std::uint32_t cell) {
  std::uint32_t mixed = cell * 0x9E3779B1u;
  mixed ^= mixed >> 15;
  const double shade = 0.55 + 0.4 * double(mixed & 0xFFu) / 255.0;
  Colour colour = level_colour(level);
  for (std::uint8_t& c : colour) c = static_cast<std::uint8_t>(std::lround(shade * double(c)));
  return colour;
}

}  // namespace cornice::viewer
