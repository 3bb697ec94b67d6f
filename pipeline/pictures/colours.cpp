// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/pictures/colours.h"

#include <algorithm>
#include <cmath>

namespace cornice::pictures {
namespace {

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

/// Hue 0..1 at fixed saturation and value.
Rgb hue_colour(double hue) {
  Rgb colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double turned = std::fmod(hue * 6.0 + (k == 0 ? 5.0 : k == 1 ? 3.0 : 1.0), 6.0);
    const double dip = std::clamp(std::min(turned, 4.0 - turned), 0.0, 1.0);
    colour[k] = to_byte(235.0 * (1.0 - 0.62 * dip));
  }
  return colour;
}

}  // namespace

Rgb class_colour(std::uint8_t classification) {
  switch (classification) {
    case 2:
      return {196, 168, 130};  // ground
    case 3:
      return {168, 204, 96};  // low, medium and high vegetation
    case 4:
      return {112, 176, 72};
    case 5:
      return {64, 140, 64};
    case 6:
      return {206, 84, 64};  // building
    case 9:
      return {72, 136, 208};  // water
    case 17:
      return {224, 176, 64};  // bridge deck
    case 7:
    case 18:
    case 65:
      return {232, 40, 200};  // noise and artefacts
    case 66:
      return {120, 220, 232};  // virtual points
    default:
      return {150, 150, 156};
  }
}

Rgb number_colour(std::uint32_t number) {
  // Steps of the golden ratio never come back close to a hue used shortly before.
  return hue_colour(std::fmod(0.6180339887498949 * number, 1.0));
}

Rgb normal_colour(Vec3f normal) {
  return {to_byte(127.5 * (1.0 + static_cast<double>(normal.x))),
          to_byte(127.5 * (1.0 + static_cast<double>(normal.y))),
          to_byte(127.5 * (1.0 + static_cast<double>(normal.z)))};
}

Rgb height_colour(double share) {
  constexpr std::array<std::array<double, 3>, 5> kStops{
      {{108, 150, 92}, {172, 184, 120}, {200, 176, 138}, {178, 166, 160}, {246, 246, 250}}};
  const double place = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  const double part = place - static_cast<double>(below);
  Rgb colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    colour[k] = to_byte((1.0 - part) * kStops[below][k] + part * kStops[below + 1][k]);
  }
  return colour;
}

Rgb shaded(Rgb colour, float light) {
  for (std::uint8_t& channel : colour) channel = to_byte(static_cast<double>(light) * channel);
  return colour;
}

}  // namespace cornice::pictures
