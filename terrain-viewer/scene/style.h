// SPDX-License-Identifier: GPL-3.0-or-later
// How the ground is painted and lit.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/base/vec.h"
#include "terrain-viewer/scene/ramp.h"

namespace cornice::viewer {

/// The numbers are those of shaders/surface.frag.
enum class Shading : int {
  kNatural = 0,  ///< snow, rock, scree, grass by slope and height
  kPlain,
  kSlope,
  kAspect,
  kAltitude,
  kSupport,
  kSource,
  kColour,
  kLevel,
  kMorph,
  kNormal,
  kCell,      ///< a colour for each cell
  kOverdraw,  ///< how often each pixel is drawn
};

/// Names as on the command line, in the order of the numbers.
inline constexpr std::array<const char*, 13> kShadingNames{
    "natural", "plain", "slope", "aspect", "altitude", "support", "source",
    "colour",  "level", "morph", "normal", "cell",     "overdraw"};
std::optional<Shading> shading_named(const std::string& name);

struct Style {
  Shading shading = Shading::kNatural;
  Vec3d sun{-0.5, 0.5, 0.7071};  ///< direction towards it, grid frame, any length
  double sun_strength = 2.2;
  double ambient = 0.9;
  double haze_range_m = 30000.0;    ///< at height 0: where droplets hide 63 %; 0: no air at all
  double haze_height_m = 2000.0;    ///< over which they thin to 1/e, 0: they do not
  double contour_interval_m = 0.0;  ///< 0: none
  double snow_line_m = 2700.0, tree_line_m = 2000.0;
  double low_m = 0.0, high_m = 4000.0;  ///< of the altitude ramp
  double support_high_m = 2.0;
  bool has_edges = false;
  double opacity = 1.0;
  double drape_opacity = 1.0;      ///< of a draped raster over these colours
  double photo_relief = 0.25;      ///< 0: photographs as they are; 1: lit as all else
  double difference_high_m = 1.0;  ///< end of the ramp of draped differences
};

/// The ramp that a shading uses; nothing where it has none.
std::optional<Ramp> ramp_of(const Style& style);

}  // namespace cornice::viewer
