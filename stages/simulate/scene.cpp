// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "stages/simulate/scene_canopy.h"
#include "stages/simulate/scene_cover.h"
#include "stages/simulate/scene_file.h"
#include "stages/simulate/scene_mesher.h"
#include "stages/simulate/scene_rays.h"
#include "stages/simulate/scene_relief.h"

namespace cornice::simulate {
namespace {

/// Ground beyond the extent that rays still meet, metres.
constexpr double kMargin = 24.0;
constexpr double kLargestSide = 20000.0;

void check(const SceneOptions& options) {
  const Box2d& e = options.extent;
  if (e.empty() || !(e.width() >= 20.0) || !(e.height() >= 20.0)) {
    throw UsageError("--extent", "must be at least 20 m wide and high");
  }
  if (e.width() > kLargestSide || e.height() > kLargestSide) {
    throw UsageError("--extent", "must be at most 20 km wide and high");
  }
  if (!(options.mesh_step_m >= 0.2 && options.mesh_step_m <= 2.0)) {
    throw UsageError("--mesh-step-m", "must be in [0.2, 2]");
  }
}

class BuiltScene final : public Scene {
 public:
  explicit BuiltScene(const SceneOptions& options)
      : options_(options), description_(read_scene_file(options.file)) {
    check(options);
    const Box2d& e = options.extent;
    origin_ = {0.5 * (e.min_x + e.max_x), 0.5 * (e.min_y + e.max_y), description_.base_m};
    const Box2d own = to_local(e);
    ground_ =
        build_ground(description_, own.grown(kMargin), options.seed, options.threads, options.file);
    rays_ = std::make_unique<GroundRays>(ground_->field, own.grown(kMargin), options.mesh_step_m,
                                         options.threads);
    const std::vector<House> houses = place_houses(description_, *ground_, own, options.seed);
    if (!houses.empty()) {
      HouseMesh mesh = mesh_houses(houses);
      house_faces_ = std::move(mesh.faces);
      houses_ = std::make_unique<RayMesh>(std::move(mesh.positions), std::move(mesh.triangles),
                                          options.threads);
      house_count_ = houses.size();
    }
    canopy_ = std::make_unique<Canopy>(
        place_trees(description_, *ground_, houses, own.grown(kMargin - 6.0), options.seed),
        own.grown(kMargin), description_.forest.returns_per_m);
    bounds_ = rays_->bounds();
    for (const House& house : houses) bounds_.max.z = std::max(bounds_.max.z, house.ridge + 1.0);
    if (canopy_->size() > 0) bounds_.max.z = std::max(bounds_.max.z, canopy_->top() + 1.0);
  }

  bool cast(const Ray& ray, Hit& hit) const override {
    const Vec3d origin = ray.origin - origin_;
    double far = 1e6;
    std::size_t face = 0;
    const bool at_house = houses_ != nullptr && cast_houses(origin, ray.direction, far, face);
    GroundHit ground;
    if (rays_->cast(origin, ray.direction, far, ground)) {
      hit.range_m = ground.range_m;
      hit.point = ground.point + origin_;
      hit.normal = normalized(ground.gradient);
      hit.surface = surface_at(ground.point, hit.normal);
      return true;
    }
    if (!at_house) return false;
    hit.range_m = far;
    hit.point = ray.origin + ray.direction * far;
    hit.normal = house_faces_[face].normal;
    hit.surface = SurfaceId::kHouse;
    return true;
  }

  bool canopy(const Ray& ray, double max_m, CanopyPassage& passage) const override {
    return canopy_->passage({ray.origin - origin_, ray.direction}, max_m, passage);
  }

  double ground_value(Vec3d p, Vec3d* gradient) const override {
    return gradient != nullptr ? ground_->field.value(p - origin_, *gradient)
                               : ground_->field.value(p - origin_);
  }

  double ground_height(double x, double y) const override {
    const double nowhere = std::numeric_limits<double>::quiet_NaN();
    if (!options_.extent.contains(x, y)) return nowhere;
    GroundHit hit;
    const Vec3d from{x - origin_.x, y - origin_.y, rays_->bounds().max.z + 1.0};
    return rays_->cast(from, {0.0, 0.0, -1.0}, 1e6, hit) ? hit.point.z + origin_.z : nowhere;
  }

  Box3d bounds() const override {
    return {{options_.extent.min_x, options_.extent.min_y, bounds_.min.z + origin_.z},
            {options_.extent.max_x, options_.extent.max_y, bounds_.max.z + origin_.z}};
  }
  const std::string& name() const override { return description_.name; }

  Mesh ground_mesh(double step_m, const Box2d& window) const override;
  Raster ground_dem(double step_m, const Box2d& window) const override;
  std::uint64_t grazing_misses() const override { return rays_->grazing_misses(); }
  std::uint64_t trees() const override { return canopy_->size(); }
  std::uint64_t houses() const override { return house_count_; }

 private:
  Box2d to_local(const Box2d& box) const {
    return {box.min_x - origin_.x, box.min_y - origin_.y, box.max_x - origin_.x,
            box.max_y - origin_.y};
  }

  bool cast_houses(Vec3d origin, Vec3d direction, double& range, std::size_t& face) const {
    // From the top of the scene, so that Embree's floats keep their digits.
    const double above = std::max(origin.z - bounds_.max.z, 0.0);
    const double start = direction.z < 0.0 ? above / -direction.z : 0.0;
    RayMesh::Hit guide{};
    if (!houses_->cast((origin + direction * start).cast<float>(), direction.cast<float>(), 1e5f,
                       guide)) {
      return false;
    }
    face = guide.primitive;
    const HouseFace& plane = house_faces_[face];
    const double slope = dot(plane.normal, direction);
    if (slope >= 0.0) return false;
    range = dot(plane.point - origin, plane.normal) / slope;
    return true;
  }

  SurfaceId surface_at(Vec3d local, Vec3d normal) const {
    if (normal.z < 0.0) return SurfaceId::kOverhang;
    const PlanField& water = ground_->water;
    if (!water.values.empty() && water.value(local.x, local.y) > 0.0) return SurfaceId::kWater;
    return SurfaceId::kGround;
  }

  void check_window(double step_m, const Box2d& window) const {
    if (!(step_m >= 0.05)) throw UsageError("--truth-step-m", "must be at least 0.05");
    const Box2d allowed = options_.extent.grown(1e-6);
    if (window.empty() || window.width() < step_m || window.height() < step_m ||
        !allowed.contains(window.min_x, window.min_y) ||
        !allowed.contains(window.max_x, window.max_y)) {
      throw UsageError("--window", "must lie within the scene's extent and be a step wide");
    }
  }

  SceneOptions options_;
  SceneDescription description_;
  Vec3d origin_;
  std::unique_ptr<Ground> ground_;
  std::unique_ptr<GroundRays> rays_;
  std::unique_ptr<RayMesh> houses_;
  std::vector<HouseFace> house_faces_;
  std::size_t house_count_ = 0;
  std::unique_ptr<Canopy> canopy_;
  Box3d bounds_;
};

Mesh BuiltScene::ground_mesh(double step_m, const Box2d& window) const {
  check_window(step_m, window);
  SurfaceOptions options;
  options.window = to_local(window);
  options.step_m = step_m;
  options.threads = options_.threads;
  const Surface surface = extract_surface(ground_->field, options);
  Mesh mesh;
  mesh.origin = surface.origin + origin_;
  mesh.positions = surface.positions;
  mesh.normals.resize(mesh.positions.size());
  ByteProperty kinds{"surface", std::vector<std::uint8_t>(mesh.positions.size())};
  parallel_for(mesh.positions.size(), 4096, options_.threads,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v) {
                   const Vec3d p = surface.origin + surface.positions[v].cast<double>();
                   Vec3d normal;
                   ground_->field.value(p, normal);
                   normal = normalized(normal);
                   mesh.normals[v] = normal.cast<float>();
                   kinds.values[v] = static_cast<std::uint8_t>(surface_at(p, normal));
                 }
               });
  mesh.byte_properties.push_back(std::move(kinds));
  mesh.triangles.reserve(2 * surface.quads.size());
  for (const auto& quad : surface.quads) {
    const auto length = [&](int a, int b) {
      const Vec3f d = mesh.positions[quad[a]] - mesh.positions[quad[b]];
      return dot(d, d);
    };
    // The shorter diagonal; it never equals another edge, for it joins cells across an edge.
    const int turn = length(0, 2) <= length(1, 3) ? 0 : 1;
    for (const int k : {turn, turn + 2}) {
      mesh.triangles.push_back({quad[k], quad[(k + 1) % 4], quad[(k + 2) % 4]});
    }
  }
  return mesh;
}

Raster BuiltScene::ground_dem(double step_m, const Box2d& window) const {
  check_window(step_m, window);
  Raster raster;
  raster.width = static_cast<int>(std::lround(window.width() / step_m));
  raster.height = static_cast<int>(std::lround(window.height() / step_m));
  raster.west = window.min_x;
  raster.north = window.max_y;
  raster.step = step_m;
  raster.values.assign(static_cast<std::size_t>(raster.width) * raster.height, raster.no_data);
  parallel_for(static_cast<std::size_t>(raster.height), 8, options_.threads,
               [&](std::size_t begin, std::size_t end) {
                 for (auto row = static_cast<int>(begin); row < static_cast<int>(end); ++row) {
                   for (int col = 0; col < raster.width; ++col) {
                     const double height = ground_height(raster.west + (col + 0.5) * step_m,
                                                         raster.north - (row + 0.5) * step_m);
                     if (!std::isnan(height)) raster.at(col, row) = static_cast<float>(height);
                   }
                 }
               });
  return raster;
}

}  // namespace

std::unique_ptr<Scene> Scene::build(const SceneOptions& options) {
  return std::make_unique<BuiltScene>(options);
}

}  // namespace cornice::simulate
