// SPDX-License-Identifier: GPL-3.0-or-later
// An orthographic view of things in space, and how finely it is drawn.
#pragma once

#include "core/base/vec.h"
#include "core/io/raster.h"

namespace cornice::pictures {

/// Where an orthographic view looks.
struct View {
  double heading_deg = 330.0;  ///< looked along, clockwise from north
  double tilt_deg = 32.0;      ///< of the view below the horizon, above 0 and up to 90
  int width_px = 1200;
};

/// The view's axes in space: right, up and forward.
struct Axes {
  Vec3d right, up, forward;
};
Axes axes_of(const View& view);

/// A position along the axes.
Vec3d seen(const Axes& axes, Vec3f position);

/// Pixels drawn per pixel of the picture, either way.
inline constexpr int kFiner = 2;
/// White border of what is drawn, in drawn pixels.
inline constexpr int kMarginPx = 8;

/// Every pixel the mean of kFiner x kFiner.
Picture reduced(const Picture& fine);

}  // namespace cornice::pictures
