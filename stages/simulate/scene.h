// SPDX-License-Identifier: GPL-3.0-or-later
// Analytic scenes: a smooth implicit ground with overhangs, houses, trees and water, known exactly.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

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

/// Between which heights a beam can meet anything, square by square.
struct HeightBounds {
  Box2d area;
  double step_m = 1.0;
  int columns = 0;
  int rows = 0;
  struct Range {
    float low = std::numeric_limits<float>::max();
    float high = std::numeric_limits<float>::lowest();
  };
  std::vector<Range> ranges;  ///< x fastest, from the south-west; empty where nothing stands

  /// Square of a place, the nearest one outside the area.
  const Range& at(double x, double y) const {
    return ranges[index(square(x, area.min_x, columns), square(y, area.min_y, rows))];
  }
  /// Widens the squares within `reach_m` of a place.
  void add(Vec3d p, double reach_m, float low, float high) {
    const int i1 = square(p.x + reach_m, area.min_x, columns);
    const int j1 = square(p.y + reach_m, area.min_y, rows);
    for (int j = square(p.y - reach_m, area.min_y, rows); j <= j1; ++j) {
      for (int i = square(p.x - reach_m, area.min_x, columns); i <= i1; ++i) {
        Range& range = ranges[index(i, j)];
        range.low = std::min(range.low, low);
        range.high = std::max(range.high, high);
      }
    }
  }

  int square(double v, double from, int count) const {
    return std::clamp(static_cast<int>((v - from) / step_m), 0, count - 1);
  }
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(i);
  }
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
  /// The same for many rays, fastest where neighbours go nearly the same way. All of one length;
  /// met[i] is 1 where hits[i] was set, else 0.
  virtual void cast_all(std::span<const Ray> rays, std::span<Hit> hits,
                        std::span<std::uint8_t> met) const {
    for (std::size_t i = 0; i < rays.size(); ++i) met[i] = cast(rays[i], hits[i]) ? 1 : 0;
  }
  /// Passage through tree crowns before range max_m; false where there is none.
  virtual bool canopy(const Ray& ray, double max_m, CanopyPassage& passage) const = 0;
  /// Signed value of the ground's implicit function, positive above ground; zero on it.
  virtual double ground_value(Vec3d p, Vec3d* gradient = nullptr) const = 0;
  /// Highest ground at a place; NaN outside the extent.
  virtual double ground_height(double x, double y) const = 0;
  virtual Box3d bounds() const = 0;
  /// Over the extent and as far around it as beams meet anything.
  virtual HeightBounds height_bounds() const {
    const Box3d box = bounds();
    return {box.plan(),
            std::max(box.max.x - box.min.x, box.max.y - box.min.y),
            1,
            1,
            {{static_cast<float>(box.min.z - 1.0), static_cast<float>(box.max.z + 1.0)}}};
  }
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
