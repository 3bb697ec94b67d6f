// SPDX-License-Identifier: GPL-3.0-or-later
// Colours for values, with what a legend needs to explain them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace cornice::viewer {

using Colour = std::array<std::uint8_t, 3>;  ///< red, green, blue, sRGB

/// Colours between stops; below the first and above the last stop the colour of that stop.
struct Ramp {
  struct Stop {
    double value = 0.0;
    Colour colour{};
    std::string label = {};  ///< of a class, in place of its value; may be empty
  };
  std::string title;        ///< "Slope"
  std::string unit;         ///< "degrees", or empty
  std::vector<Stop> stops;  ///< two or more, values rising
  bool is_stepped = false;  ///< classes: each stop's colour holds up to the next stop

  double low() const { return stops.front().value; }
  double high() const { return stops.back().value; }
  Colour at(double value) const;
  /// Colours at `count` equal steps from low() to high(), each in the middle of its step.
  std::vector<Colour> table(std::size_t count) const;
};

/// Slope in the classes of avalanche maps: 30, 35, 40, 45 degrees; steeper rock and overhangs.
Ramp slope_ramp();
/// Azimuth of the fall line from north, the same colour at 0 and 360 degrees.
Ramp aspect_ramp();
/// Heights of a landscape between two heights.
Ramp altitude_ramp(double low_m, double high_m);
/// Distance to the nearest measured point: measured ground is pale, invented ground is not.
Ramp support_ramp(double high_m);
/// Differences around zero: blue below, red above.
Ramp difference_ramp(double high_m);
/// Where a vertex comes from: measured, bridged, elevation model.
Ramp source_ramp();
/// From a vertex's parent (0) to the vertex itself (1).
Ramp morph_ramp();

/// How often a pixel is drawn, 0 to 8 and more: the shader takes its colours from here.
Ramp overdraw_ramp();

/// A colour for each level of a hierarchy, neighbours apart.
Colour level_colour(int level);
/// A colour for each cell of a level: the level's, lighter or darker.
Colour cell_colour(int level, std::uint32_t cell);

}  // namespace cornice::viewer
