// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes whose every answer can be worked out by hand.
#pragma once

#include <string>

#include "stages/simulate/scene.h"

namespace cornice::test {

/// A plane z = height + slope_x (x - west) over `extent`, with what stands on it in strips of x.
struct PlaneScene : simulate::Scene {
  Box2d extent;
  double height = 500.0;
  double slope_x = 0.0;
  /// Crowns from canopy_low to canopy_high above the ground for x in [canopy_west, canopy_east].
  double canopy_west = 0.0, canopy_east = 0.0, canopy_low = 3.0, canopy_high = 15.0;
  double canopy_density = 0.2;
  /// Water for x in [water_west, water_east].
  double water_west = 0.0, water_east = 0.0;
  /// A vertical wall at x = wall_x, as high as wall_height: the ground east of it is higher.
  double wall_x = 1e12, wall_height = 0.0;

  double ground(double x) const {
    return height + slope_x * (x - extent.min_x) + (x > wall_x ? wall_height : 0.0);
  }

  bool cast(const simulate::Ray& ray, simulate::Hit& hit) const override;
  bool canopy(const simulate::Ray& ray, double max_m,
              simulate::CanopyPassage& passage) const override;
  double ground_value(Vec3d p, Vec3d* gradient) const override;
  double ground_height(double x, double y) const override;
  Box3d bounds() const override;
  const std::string& name() const override { return name_; }
  Mesh ground_mesh(double step_m, const Box2d& window) const override;
  Raster ground_dem(double step_m, const Box2d& window) const override;
  std::uint64_t grazing_misses() const override { return 0; }
  std::uint64_t trees() const override { return 0; }
  std::uint64_t houses() const override { return 0; }

 private:
  std::string name_ = "plane";
};

}  // namespace cornice::test
