// SPDX-License-Identifier: GPL-3.0-or-later
// What of the ground lies under a pixel, from the depths that were drawn.
#pragma once

#include <functional>
#include <optional>

#include "terrain-viewer/scene/camera.h"

namespace cornice::viewer {

/// A place on the ground and how steep it is there, degrees; nothing where that cannot be told.
struct UnderCursor {
  Vec3d point;
  std::optional<double> slope_deg;
  friend bool operator==(const UnderCursor&, const UnderCursor&) = default;
};

/// The point seen in a pixel (x, y) of a picture of that size, given its depth (1 at kNearM, 0 at
/// infinity). Nothing at depth 0: sky.
std::optional<Vec3d> point_of_depth(const Camera& camera, int width, int height, double x, double y,
                                    float depth);

/// What is under (x, y); point: the ground seen in a pixel, asked for there and three pixels right
/// and below, whose triangle gives the slope.
UnderCursor look_under(double x, double y, Vec3d here,
                       const std::function<std::optional<Vec3d>(double x, double y)>& point);

}  // namespace cornice::viewer
