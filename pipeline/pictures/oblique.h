// SPDX-License-Identifier: GPL-3.0-or-later
// Points seen obliquely from above, shaded by the shape they show.
#pragma once

#include <vector>

#include "core/base/vec.h"
#include "pipeline/pictures/colours.h"
#include "pipeline/pictures/view.h"

namespace cornice::pictures {

/// N points with a colour each; metres, relative to any common origin.
struct ColouredPoints {
  std::vector<Vec3f> positions;
  std::vector<Rgb> colours;
};

/// The points under a light from the upper left. The picture is as high as the points need.
/// Throws UsageError where there are no points.
Picture oblique_picture(const ColouredPoints& points, const View& view);

}  // namespace cornice::pictures
