// SPDX-License-Identifier: GPL-3.0-or-later
// Reversed infinite depth: Upchurch and Desbrun, "Tightening the precision of perspective
// rendering", Journal of Graphics Tools 16(1), 2012.
#include "terrain-viewer/scene/camera.h"

#include <cmath>
#include <numbers>

namespace cornice::viewer {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

double half_height(const Camera& camera) {
  return std::tan(0.5 * camera.field_of_view_deg * kRadians);
}

}  // namespace

CameraAxes axes_of(const Camera& camera) {
  const double heading = camera.heading_deg * kRadians;
  const double pitch = camera.pitch_deg * kRadians;
  const Vec3d forward{std::sin(heading) * std::cos(pitch), std::cos(heading) * std::cos(pitch),
                      std::sin(pitch)};
  const Vec3d right{std::cos(heading), -std::sin(heading), 0.0};
  return {forward, right, cross(right, forward)};
}

Camera looking_at(const Camera& like, Vec3d eye, Vec3d target) {
  Camera camera = like;
  camera.eye = eye;
  const Vec3d way = target - eye;
  const double plan = std::hypot(way.x, way.y);
  if (plan > 1e-9 * norm(way))
    camera.heading_deg = std::fmod(std::atan2(way.x, way.y) / kRadians + 360.0, 360.0);
  if (norm(way) > 0.0) camera.pitch_deg = std::atan2(way.z, plan) / kRadians;
  return camera;
}

Matrix4 view_projection(const Camera& camera, double width_over_height, double near_m) {
  const CameraAxes axes = axes_of(camera);
  const double y = 1.0 / half_height(camera);
  const double x = y / width_over_height;
  const auto column = [&](double right, double up, double forward) {
    return std::array<float, 4>{static_cast<float>(x * right), static_cast<float>(y * up), 0.0f,
                                static_cast<float>(forward)};
  };
  Matrix4 m{};
  const std::array<std::array<float, 4>, 3> columns{
      column(axes.right.x, axes.up.x, axes.forward.x),
      column(axes.right.y, axes.up.y, axes.forward.y),
      column(axes.right.z, axes.up.z, axes.forward.z)};
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t r = 0; r < 4; ++r) m[4 * c + r] = columns[c][r];
  m[14] = static_cast<float>(near_m);
  return m;
}

Vec3d ray_of_pixel(const Camera& camera, int width, int height, double x, double y) {
  const CameraAxes axes = axes_of(camera);
  const double scale = half_height(camera) / (0.5 * height);
  const double right = (x + 0.5 - 0.5 * width) * scale;
  const double up = (0.5 * height - y - 0.5) * scale;
  return normalized(axes.forward + right * axes.right + up * axes.up);
}

std::optional<Vec3d> pixel_of_point(const Camera& camera, int width, int height, Vec3d point) {
  const CameraAxes axes = axes_of(camera);
  const Vec3d way = point - camera.eye;
  const double depth = dot(way, axes.forward);
  if (!(depth > 0.0)) return std::nullopt;
  const double scale = 0.5 * height / (half_height(camera) * depth);
  return Vec3d{0.5 * width - 0.5 + scale * dot(way, axes.right),
               0.5 * height - 0.5 - scale * dot(way, axes.up), depth};
}

Camera between(const Camera& a, const Camera& b, double t) {
  Camera camera;
  camera.eye = a.eye + t * (b.eye - a.eye);
  const double turn = std::remainder(b.heading_deg - a.heading_deg, 360.0);
  camera.heading_deg = std::fmod(a.heading_deg + t * turn + 720.0, 360.0);
  camera.pitch_deg = std::lerp(a.pitch_deg, b.pitch_deg, t);
  camera.field_of_view_deg = std::lerp(a.field_of_view_deg, b.field_of_view_deg, t);
  return camera;
}

}  // namespace cornice::viewer
