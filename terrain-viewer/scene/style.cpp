// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/scene/style.h"

#include <algorithm>

namespace cornice::viewer {

std::optional<Shading> shading_named(const std::string& name) {
  const auto found = std::find(kShadingNames.begin(), kShadingNames.end(), name);
  if (found == kShadingNames.end()) return std::nullopt;
  return static_cast<Shading>(found - kShadingNames.begin());
}

std::optional<Ramp> ramp_of(const Style& style) {
  switch (style.shading) {
    case Shading::kSlope:
      return slope_ramp();
    case Shading::kAspect:
      return aspect_ramp();
    case Shading::kAltitude:
      return altitude_ramp(style.low_m, style.high_m);
    case Shading::kSupport:
      return support_ramp(style.support_high_m);
    case Shading::kSource:
      return source_ramp();
    case Shading::kMorph:
      return morph_ramp();
    case Shading::kOverdraw:
      return overdraw_ramp();
    default:
      return std::nullopt;
  }
}

}  // namespace cornice::viewer
