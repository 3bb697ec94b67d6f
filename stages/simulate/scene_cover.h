// SPDX-License-Identifier: GPL-3.0-or-later
// What stands on the ground: houses and trees.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "stages/simulate/scene_canopy.h"
#include "stages/simulate/scene_file.h"
#include "stages/simulate/scene_relief.h"

namespace cornice::simulate {

/// A box with a gable roof along its longer side.
struct House {
  double x = 0.0, y = 0.0;
  Vec2d along;  ///< unit, of the roof's ridge
  double half_length = 0.0, half_width = 0.0;
  double foot = 0.0, eaves = 0.0, ridge = 0.0;

  /// True within `margin_m` of its walls, in plan.
  bool covers(double px, double py, double margin_m) const;
};

struct HouseFace {
  Vec3d point;
  Vec3d normal;
};

/// Triangles of all houses; face number per triangle.
struct HouseMesh {
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<HouseFace> faces;  ///< one per triangle
};

std::vector<House> place_houses(const SceneDescription& scene, const Ground& ground,
                                const Box2d& area, std::uint64_t seed);
HouseMesh mesh_houses(const std::vector<House>& houses);

std::vector<Tree> place_trees(const SceneDescription& scene, const Ground& ground,
                              const std::vector<House>& houses, const Box2d& area,
                              std::uint64_t seed);

}  // namespace cornice::simulate
