// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/pick.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cornice::viewer {

std::optional<Vec3d> point_of_depth(const Camera& camera, int width, int height, double x, double y,
                                    float depth) {
  if (!(depth > 0.0f)) return std::nullopt;
  const Vec3d ray = ray_of_pixel(camera, width, height, std::floor(x), std::floor(y));
  const double along = kNearM / double(depth);
  return camera.eye + along / dot(ray, axes_of(camera).forward) * ray;
}

UnderCursor look_under(double x, double y, Vec3d here,
                       const std::function<std::optional<Vec3d>(double x, double y)>& point) {
  constexpr double kStepPixels = 3.0;
  UnderCursor under{here, std::nullopt};
  const auto right = point(x + kStepPixels, y), below = point(x, y + kStepPixels);
  if (!right || !below) return under;
  const Vec3d normal = cross(*below - here, *right - here);
  if (norm(normal) > 0.0)
    under.slope_deg =
        std::acos(std::min(1.0, std::abs(normalized(normal).z))) * 180.0 / std::numbers::pi;
  return under;
}

}  // namespace cornice::viewer
