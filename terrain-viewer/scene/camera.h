// SPDX-License-Identifier: GPL-3.0-or-later
// Where one looks from, where to, and what a pixel sees.
#pragma once

#include <array>
#include <optional>

#include "core/base/vec.h"

namespace cornice::viewer {

/// 4 x 4, columns first, as OpenGL takes it.
using Matrix4 = std::array<float, 16>;

/// What is nearer to the eye is not drawn, metres.
inline constexpr double kNearM = 0.1;

/// An eye without roll. Frame: x east, y north, z up, metres, projected CRS.
struct Camera {
  Vec3d eye;
  double heading_deg = 0.0;         ///< of the line of sight, clockwise from grid north
  double pitch_deg = 0.0;           ///< above the horizon; -90 is straight down
  double field_of_view_deg = 45.0;  ///< from the lower to the upper edge of the picture, 1..150

  friend bool operator==(const Camera&, const Camera&) = default;
};

/// Unit vectors of a camera in the world's frame.
struct CameraAxes {
  Vec3d forward, right, up;
};
CameraAxes axes_of(const Camera& camera);

/// The camera at `eye` that looks at `target`; heading as in `like` where the target is straight
/// above or below.
Camera looking_at(const Camera& like, Vec3d eye, Vec3d target);

/// From positions relative to the eye to clip space with reversed infinite depth: 1 at near_m, 0 at
/// infinity (glClipControl zero to one, depth test "greater").
Matrix4 view_projection(const Camera& camera, double width_over_height, double near_m);

/// Unit direction in which the centre of pixel (x, y) looks; (0, 0) is the upper left corner of the
/// picture.
Vec3d ray_of_pixel(const Camera& camera, int width, int height, double x, double y);

/// The pixel (x, y) in which a point is seen and its distance along the line of sight; nothing
/// behind the eye.
std::optional<Vec3d> pixel_of_point(const Camera& camera, int width, int height, Vec3d point);

/// Between two cameras, t from 0 to 1: straight for the eye, the shorter way round for the heading.
Camera between(const Camera& a, const Camera& b, double t);

}  // namespace cornice::viewer
