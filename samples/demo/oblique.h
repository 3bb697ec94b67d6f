// SPDX-License-Identifier: GPL-3.0-or-later
// Points seen obliquely from above, shaded by the shape they show.
#pragma once

#include <vector>

#include "core/base/vec.h"
#include "samples/demo/colours.h"

namespace cornice::demo {

/// N points with a colour each; metres, relative to any common origin.
struct ColouredPoints {
  std::vector<Vec3f> positions;
  std::vector<Rgb> colours;
};

/// Where an orthographic view looks.
struct ObliqueView {
  double heading_deg = 330.0;  ///< looked along, clockwise from north
  double tilt_deg = 32.0;      ///< of the view below the horizon, above 0 and up to 90
  int width_px = 1200;
};

/// The points under a light from the upper left. The picture is as high as the points need.
/// Throws UsageError where there are no points.
Picture oblique_picture(const ColouredPoints& points, const ObliqueView& view);

}  // namespace cornice::demo
