// SPDX-License-Identifier: GPL-3.0-or-later
// Analytic scenes: a smooth implicit ground with overhangs, houses, trees and water, known exactly.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/vec.h"
#include "core/io/raster.h"
#include "core/mesh/mesh.h"

namespace cornice::simulate {

/// What a beam meets. Stored with every true point.
enum class SurfaceId : std::uint8_t {
  kGround = 1,
  kVegetation = 2,
  kHouse = 3,
  kWater = 4,
  kOverhang = 5,  ///< ground whose outward normal points below the horizon
};

struct Ray {
  Vec3d origin;
  Vec3d direction;  ///< unit
};

struct Hit {
  double range_m = 0.0;
  Vec3d point;   ///< on the analytic surface, to 1e-6 m along the ray
  Vec3d normal;  ///< unit, out of the ground
  SurfaceId surface = SurfaceId::kGround;
};

/// One hit of the canopy on the way to the ground: entry and exit of the beam in the crown volume.
struct CanopyPassage {
  double enter_m = 0.0;  ///< range
  double exit_m = 0.0;
  double density = 0.0;  ///< mean returns per metre of path, 1/m
};

/// Parameters of a scene file (samples/scenes/*.yaml), all lengths in metres.
struct SceneOptions {
  std::filesystem::path file;  ///< a scene YAML
  std::uint64_t seed = 1;
  /// Ground covered, in the product's projected CRS.
  Box2d extent;
  /// Of the mesh that guides the rays: memory and time to build grow with its inverse square, the
  /// hits stay exact. In [0.2, 2].
  double mesh_step_m = 1.0;
  int threads = 0;
};

/// A built scene. Thread contract: const members may be called from many threads.
class Scene {
 public:
  /// Throws InputError naming the file and key for bad YAML, UsageError for an impossible extent.
  static std::unique_ptr<Scene> build(const SceneOptions& options);
  virtual ~Scene() = default;

  /// First surface that is not vegetation. False where the ray leaves the scene.
  virtual bool cast(const Ray& ray, Hit& hit) const = 0;
  /// Passage through tree crowns before range max_m; false where there is none.
  virtual bool canopy(const Ray& ray, double max_m, CanopyPassage& passage) const = 0;
  /// Signed value of the ground's implicit function, positive above ground; zero on it.
  virtual double ground_value(Vec3d p, Vec3d* gradient = nullptr) const = 0;
  /// Highest ground at a place; NaN outside the extent.
  virtual double ground_height(double x, double y) const = 0;
  virtual Box3d bounds() const = 0;
  virtual const std::string& name() const = 0;

  /// The ground as a closed-in-plan mesh at `step_m` (vertices on the analytic surface to 1e-4 m,
  /// analytic normals, byte property "surface"), cut to `window`.
  virtual Mesh ground_mesh(double step_m, const Box2d& window) const = 0;
  /// Highest ground per pixel, as DEM products hold it.
  virtual Raster ground_dem(double step_m, const Box2d& window) const = 0;

  /// Rays so far that cast() gave up on because they slid along the ground without settling.
  virtual std::uint64_t grazing_misses() const = 0;
  virtual std::uint64_t trees() const = 0;
  virtual std::uint64_t houses() const = 0;
};

}  // namespace cornice::simulate
