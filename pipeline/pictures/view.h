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

/// A picture is at most this much higher than wide: a survey may be a long strip from south to
/// north.
inline constexpr double kMostHeight = 1.5;

/// How what is seen lies on the drawn pixels: in the middle, with the margin around it.
struct Frame {
  Box3d box;  ///< of what is seen, along the axes
  double px_per_m = 1.0;
  double left_px = 0.0;  ///< of the box
  int width = 0;
  int height = 0;

  /// x to the right, y down, z away from the viewer.
  Vec3d place(const Vec3d& p) const {
    return {left_px + (p.x - box.min.x) * px_per_m, kMarginPx + (box.max.y - p.y) * px_per_m,
            (p.z - box.min.z) * px_per_m};
  }
  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
};

/// `box`: of what is seen, not empty.
Frame frame_of(const View& view, const Box3d& box);

/// Every pixel the mean of kFiner x kFiner.
Picture reduced(const Picture& fine);

}  // namespace cornice::pictures
