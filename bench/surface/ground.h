// SPDX-License-Identifier: GPL-3.0-or-later
// Oriented points of a simulated ground, made by our own stages, beside the ground itself.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/mesh.h"
#include "stages/simulate/scene.h"

namespace cornice::bench {

struct GroundPlan {
  std::filesystem::path scene;  ///< a scene's YAML
  double size_m = 200.0;        ///< of the square; whole metres
  double density = 20.0;        ///< points/m²
  double noise_m = 0.03;        ///< standard deviation of a point in space
  std::uint64_t seed = 1;
};

struct Ground {
  std::unique_ptr<simulate::Scene> scene;
  Box2d extent;
  OrientedPoints points;  ///< with normals as cornice-normals estimates them
};

/// Flies over the scene, finds the flight lines (cornice-flightlines from the folder `programs`)
/// and orients the points. Files go below `folder`. Throws RunError where a program fails.
Ground fly_ground(const GroundPlan& plan, const std::filesystem::path& programs,
                  const std::filesystem::path& folder, int threads);

/// The oriented points with what the scene knows: moved onto the ground, with the ground's normals,
/// or both. Points whose place on the ground is not found stay as they are.
enum class Known { kNothing, kPlaces, kNormals, kBoth };
OrientedPoints with_known(const Ground& ground, Known known, int threads);

/// A point of the ground near `p`: the zero of its implicit function along the gradient. `p`'s
/// distance from it is p's distance from the ground to second order.
struct GroundPoint {
  Vec3d at;
  Vec3d normal;
  bool found = false;  ///< the search has come to rest
};
GroundPoint nearest_ground(const simulate::Scene& scene, Vec3d p);

}  // namespace cornice::bench
