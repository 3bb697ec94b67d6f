// SPDX-License-Identifier: GPL-3.0-or-later
// A bar of a round length over the picture, and where there is room for it.
#pragma once

#include <string>

#include "terrain-viewer/scene/camera.h"

namespace cornice::viewer {

struct ScaleBar {
  double length_m = 0.0;
  double pixels = 0.0;  ///< how long that is in the picture
  std::string label;    ///< "200 m", "5 km"
};

/// The longest bar of 1, 2 or 5 times a power of ten metres that takes at most `most_pixels`, for
/// what lies across the line of sight at depth_m along it. height: of the picture, pixels.
ScaleBar scale_bar(const Camera& camera, int height, double depth_m, double most_pixels);

/// Right end and lower edge of the bar, pixels from the upper left corner.
struct ScalePlace {
  float right = 0.0f, low = 0.0f;
};

/// In the lower right corner of a picture; above what reaches in from the lower left, whose right
/// and upper edges are given, where the bar would lie over it. wide: the bar's or its label's
/// width, pixels.
ScalePlace scale_place(int width, int height, float wide, float taken_right, float taken_top);

}  // namespace cornice::viewer
