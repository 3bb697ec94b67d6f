// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene.h"

#include <algorithm>
#include <array>
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
/// Beyond the range of any scanner, metres.
constexpr double kFarthest = 1e6;

void check(const SceneOptions& options) {
  const Box2d& e = options.extent;
  if (e.empty() || !(e.width() >= 20.0) || !(e.height() >= 20.0)) {
    throw UsageError("--tile-size", "the scene must be at least 20 m wide and high");
  }
  if (e.width() > kLargestSide || e.height() > kLargestSide) {
    throw UsageError("--tiles", "the scene must be at most 20 km wide and high");
  }
  if (!(options.mesh_step_m >= 0.2 && options.mesh_step_m <= 2.0)) {
    throw UsageError("scene", "the step of the mesh that guides the rays must be in [0.2, 2]");
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
    std::vector<Tree> trees =
        place_trees(description_, *ground_, houses, own.grown(kMargin - 6.0), options.seed);
    bound_heights(houses, trees);
    canopy_ = std::make_unique<Canopy>(std::move(trees), own.grown(kMargin),
                                       description_.forest.returns_per_m);
    bounds_ = rays_->bounds();
    for (const House& house : houses) bounds_.max.z = std::max(bounds_.max.z, house.ridge + 1.0);
    if (canopy_->size() > 0) bounds_.max.z = std::max(bounds_.max.z, canopy_->top() + 1.0);
  }

  bool cast(const Ray& ray, Hit& hit) const override {
    const Vec3d origin = ray.origin - origin_;
    double far = kFarthest;
    std::size_t face = 0;
    const bool at_house = houses_ != nullptr && cast_houses(origin, ray.direction, far, face);
    GroundHit ground;
    if (rays_->cast(origin, ray.direction, far, ground)) {
      hit = at_ground(ground);
      return true;
    }
    if (at_house) hit = at_face(ray, far, face);
    return at_house;
  }

  void cast_all(std::span<const Ray> rays, std::span<Hit> hits,
                std::span<std::uint8_t> met) const override {
    constexpr std::size_t kPacket = GroundRays::kPacket;
    std::array<GroundRay, kPacket> local;
    std::array<GroundHit, kPacket> ground;
    std::array<std::size_t, kPacket> face{};
    std::array<std::uint8_t, kPacket> at_house{};
    for (std::size_t first = 0; first < rays.size(); first += kPacket) {
      const std::size_t count = std::min(kPacket, rays.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        const Ray& ray = rays[first + i];
        local[i] = {ray.origin - origin_, ray.direction, kFarthest};
        if (houses_ == nullptr) continue;
        at_house[i] = cast_houses(local[i].origin, ray.direction, local[i].far_m, face[i]) ? 1 : 0;
      }
      rays_->cast({local.data(), count}, {ground.data(), count}, met.subspan(first, count));
      for (std::size_t i = 0; i < count; ++i) {
        if (met[first + i] != 0) {
          hits[first + i] = at_ground(ground[i]);
        } else if (at_house[i] != 0) {
          hits[first + i] = at_face(rays[first + i], local[i].far_m, face[i]);
          met[first + i] = 1;
        }
      }
    }
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
    // A beam that slides down an upright wall settles nowhere; one beside it does.
    constexpr double kBeside = 1e-4;
    constexpr double kPlaces[][2] = {{0, 0}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}, {7, 4}, {-4, 7}};
    for (const auto& place : kPlaces) {
      GroundHit hit;
      const Vec3d from{x - origin_.x + kBeside * place[0], y - origin_.y + kBeside * place[1],
                       rays_->bounds().max.z + 1.0};
      if (rays_->cast(from, {0.0, 0.0, -1.0}, kFarthest, hit)) return hit.point.z + origin_.z;
    }
    return nowhere;
  }

  Box3d bounds() const override {
    return {{options_.extent.min_x, options_.extent.min_y, bounds_.min.z + origin_.z},
            {options_.extent.max_x, options_.extent.max_y, bounds_.max.z + origin_.z}};
  }
  HeightBounds height_bounds() const override { return heights_; }
  const std::string& name() const override { return description_.name; }

  Mesh ground_mesh(double step_m, const Box2d& window) const override;
  Raster ground_dem(double step_m, const Box2d& window) const override;
  std::uint64_t grazing_misses() const override { return rays_->grazing_misses(); }
  std::uint64_t trees() const override { return canopy_->size(); }
  std::uint64_t houses() const override { return house_count_; }

 private:
  void bound_heights(const std::vector<House>& houses, const std::vector<Tree>& trees) {
    heights_ = rays_->height_bounds();
    for (const House& house : houses)
      heights_.add({house.x, house.y, 0.0}, house.half_length + house.half_width,
                   static_cast<float>(house.foot), static_cast<float>(house.ridge));
    for (const Tree& tree : trees)
      heights_.add(tree.middle.cast<double>(), static_cast<double>(tree.radius),
                   tree.middle.z - tree.half_height, tree.middle.z + tree.half_height);
    Box2d& area = heights_.area;
    area = {area.min_x + origin_.x, area.min_y + origin_.y, area.max_x + origin_.x,
            area.max_y + origin_.y};
    for (HeightBounds::Range& range : heights_.ranges) {
      range.low = static_cast<float>(static_cast<double>(range.low) + origin_.z);
      range.high = static_cast<float>(static_cast<double>(range.high) + origin_.z);
    }
  }

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

  Hit at_ground(const GroundHit& ground) const {
    const Vec3d normal = normalized(ground.gradient);
    return {ground.range_m, ground.point + origin_, normal, surface_at(ground.point, normal)};
  }

  Hit at_face(const Ray& ray, double range, std::size_t face) const {
    return {range, ray.origin + ray.direction * range, house_faces_[face].normal,
            SurfaceId::kHouse};
  }

  SurfaceId surface_at(Vec3d local, Vec3d normal) const {
    if (normal.z < 0.0) return SurfaceId::kOverhang;
    const PlanField& water = ground_->water;
    if (!water.values.empty() && water.value(local.x, local.y) > 0.0) return SurfaceId::kWater;
    return SurfaceId::kGround;
  }

  void check_window(const char* option, double step_m, const Box2d& window) const {
    if (!(step_m >= 0.05)) throw UsageError(option, "must be at least 0.05 m");
    const Box2d allowed = options_.extent.grown(1e-6);
    if (window.empty() || window.width() < step_m || window.height() < step_m ||
        !allowed.contains(window.min_x, window.min_y) ||
        !allowed.contains(window.max_x, window.max_y)) {
      throw UsageError(option, "the window must lie within the scene and be a step wide");
    }
  }

  SceneOptions options_;
  SceneDescription description_;
  Vec3d origin_;
  std::unique_ptr<Ground> ground_;
  std::unique_ptr<GroundRays> rays_;
  HeightBounds heights_;  ///< in the coordinates of the product
  std::unique_ptr<RayMesh> houses_;
  std::vector<HouseFace> house_faces_;
  std::size_t house_count_ = 0;
  std::unique_ptr<Canopy> canopy_;
  Box3d bounds_;
};

Mesh BuiltScene::ground_mesh(double step_m, const Box2d& window) const {
  check_window("--truth-mesh-step", step_m, window);
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
  check_window("--truth-dem-step", step_m, window);
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
