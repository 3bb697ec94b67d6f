// SPDX-License-Identifier: GPL-3.0-or-later
#include "property/simulate_survey/test_scenes.h"

#include <algorithm>
#include <cmath>

namespace cornice::test {

using simulate::CanopyPassage;
using simulate::Hit;
using simulate::Ray;
using simulate::SurfaceId;

bool PlaneScene::cast(const Ray& ray, Hit& hit) const {
  const Vec3d o = ray.origin, d = ray.direction;
  double best = 1e12;
  const auto try_plane = [&](bool is_east) {
    // z = base + slope_x (x - west)
    const double base = height + (is_east ? wall_height : 0.0);
    const double along = d.z - slope_x * d.x;
    if (along >= 0.0) return;
    const double range = (base + slope_x * (o.x - extent.min_x) - o.z) / along;
    const double x = o.x + range * d.x;
    if (range <= 0.0 || range >= best || (x > wall_x) != is_east) return;
    best = range;
    hit.normal = normalized(Vec3d{-slope_x, 0.0, 1.0});
    hit.surface =
        x >= water_west && x < water_east && !is_east ? SurfaceId::kWater : SurfaceId::kGround;
  };
  try_plane(false);
  if (wall_height > 0.0) {
    try_plane(true);
    const double range = d.x > 0.0 ? (wall_x - o.x) / d.x : -1.0;
    const double z = o.z + range * d.z, foot = height + slope_x * (wall_x - extent.min_x);
    if (range > 0.0 && range < best && z >= foot && z <= foot + wall_height) {
      best = range;
      hit.normal = {-1.0, 0.0, 0.0};
      hit.surface = SurfaceId::kGround;
    }
  }
  if (best >= 1e12) return false;
  hit.range_m = best;
  hit.point = o + best * d;
  return extent.grown(100.0).contains(hit.point.x, hit.point.y);
}

bool PlaneScene::canopy(const Ray& ray, double max_m, CanopyPassage& passage) const {
  if (canopy_east <= canopy_west) return false;
  const auto range_at = [&](double above) {
    return (height + slope_x * (ray.origin.x - extent.min_x) + above - ray.origin.z) /
           (ray.direction.z - slope_x * ray.direction.x);
  };
  passage.enter_m = range_at(canopy_high);
  passage.exit_m = std::min(max_m, range_at(canopy_low));
  const double x = ray.origin.x + passage.enter_m * ray.direction.x;
  passage.density = canopy_density;
  return x >= canopy_west && x < canopy_east && passage.enter_m < passage.exit_m;
}

double PlaneScene::ground_value(Vec3d p, Vec3d* gradient) const {
  if (gradient != nullptr) *gradient = {-slope_x, 0.0, 1.0};
  return p.z - ground(p.x);
}

double PlaneScene::ground_height(double x, double) const { return ground(x); }

Box3d PlaneScene::bounds() const {
  const double a = ground(extent.min_x), b = ground(extent.max_x);
  return {{extent.min_x, extent.min_y, std::min(a, b) - 1.0},
          {extent.max_x, extent.max_y, std::max(a, b) + canopy_high + 1.0}};
}

Mesh PlaneScene::ground_mesh(double, const Box2d& window) const {
  Mesh mesh;
  mesh.origin = {window.min_x, window.min_y, 0.0};
  const auto w = static_cast<float>(window.width()), h = static_cast<float>(window.height());
  const auto z0 = static_cast<float>(ground(window.min_x)),
             z1 = static_cast<float>(ground(window.max_x));
  mesh.positions = {{0, 0, z0}, {w, 0, z1}, {w, h, z1}, {0, h, z0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Raster PlaneScene::ground_dem(double step_m, const Box2d& window) const {
  Raster raster;
  raster.width = static_cast<int>(window.width() / step_m);
  raster.height = static_cast<int>(window.height() / step_m);
  raster.west = window.min_x;
  raster.north = window.max_y;
  raster.step = step_m;
  for (int row = 0; row < raster.height; ++row)
    for (int col = 0; col < raster.width; ++col)
      raster.values.push_back(static_cast<float>(ground(window.min_x + (col + 0.5) * step_m)));
  return raster;
}

}  // namespace cornice::test
