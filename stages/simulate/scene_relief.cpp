// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_relief.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "stages/simulate/scene_erosion.h"
#include "stages/simulate/scene_noise.h"

namespace cornice::simulate {
namespace {

constexpr double kRockStep = 4.0;
constexpr double kErosionBorder = 240.0;

double tangent(double degrees) { return std::tan(degrees * std::numbers::pi / 180.0); }

PlanLattice lattice_over(const Box2d& box, double step) {
  PlanLattice lattice;
  lattice.step = step;
  lattice.per_metre = 1.0 / step;
  lattice.x0 = (std::floor(box.min_x / step) - 2) * step;
  lattice.y0 = (std::floor(box.min_y / step) - 2) * step;
  lattice.nx = static_cast<int>(std::ceil((box.max_x - lattice.x0) / step)) + 3;
  lattice.ny = static_cast<int>(std::ceil((box.max_y - lattice.y0) / step)) + 3;
  return lattice;
}

template <class Visit>
void for_nodes(const PlanLattice& lattice, int threads, Visit visit) {
  parallel_for(static_cast<std::size_t>(lattice.ny), 16, threads,
               [&](std::size_t begin, std::size_t end) {
                 for (auto j = static_cast<int>(begin); j < static_cast<int>(end); ++j) {
                   for (int i = 0; i < lattice.nx; ++i) visit(i, j);
                 }
               });
}

double smooth_side(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

/// A place in the frame of a direction: along it and to its left.
struct Frame {
  double along, left;
};
Frame in_frame(Vec2d at, Vec2d direction, double x, double y) {
  const double dx = x - at.x, dy = y - at.y;
  return {dx * direction.x + dy * direction.y, -dx * direction.y + dy * direction.x};
}

double distance_to_segment(Vec2d a, Vec2d b, double x, double y, double& t) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  t = std::clamp(((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return std::hypot(x - a.x - t * dx, y - a.y - t * dy);
}

/// The large shape, before erosion.
double large_shape(const SceneDescription& scene, double x, double y, std::uint64_t seed) {
  const Vec2d down = azimuth_direction(scene.slope_azimuth_deg);
  double h = -0.01 * scene.slope_percent * (down.x * x + down.y * y);
  const double wx = x + 60.0 * fractal_noise(x / 330.0, y / 330.0, 3, 0.5, seed + 21);
  const double wy = y + 60.0 * fractal_noise(x / 330.0, y / 330.0, 3, 0.5, seed + 22);
  double crest = 0.0;
  for (const RidgeShape& ridge : scene.ridges) {
    double t;
    const double d = distance_to_segment(ridge.from, ridge.to, wx, wy, t) / ridge.half_width_m;
    const double height = ridge.height_m * (1.0 + 0.22 * gradient_noise(t * 5.0, 0.5, seed + 23));
    // Steeper towards the crest.
    crest = std::max(crest, height * std::exp(-1.55 * std::pow(d, 1.15)));
  }
  h += crest;
  if (scene.detail.height_m > 0.0) {
    // Unevenness for the water to gather in.
    const double s = 1.6 * scene.detail.wavelength_m;
    h += scene.detail.height_m * fractal_noise(wx / s, wy / s, 4, 0.6, seed + 26);
  }
  if (scene.hills.height_m > 0.0) {
    const double s = scene.hills.wavelength_m;
    h += scene.hills.height_m * fractal_noise(x / s, y / s, 4, 0.45, seed + 24);
  }
  if (scene.mountains.height_m > 0.0) {
    const double s = scene.mountains.wavelength_m;
    h += scene.mountains.height_m * ridged_noise(wx / s, wy / s, 4, 0.45, seed + 25);
  }
  return h;
}

/// Small ridges and hollows, strong where the ground is steep.
double small_shape(const NoiseShape& detail, double steepness, double x, double y,
                   std::uint64_t seed) {
  if (detail.height_m <= 0.0) return 0.0;
  int octaves = 1;
  for (double wave = detail.wavelength_m; wave > 14.0 && octaves < 8; wave *= 0.5) ++octaves;
  const double s = detail.wavelength_m;
  const double rough = smooth_step(0.35, 1.1, steepness);
  const double crests = 2.0 * ridged_noise(x / s, y / s, octaves, 0.5, seed + 31) - 1.0;
  const double knolls = fractal_noise(x / s, y / s, std::min(octaves, 4), 0.42, seed + 32);
  return detail.height_m * (rough * crests + (0.12 + 0.2 * rough) * knolls);
}

double wall_step(const WallShape& wall, Vec2d at, double x, double y, std::uint64_t seed) {
  const Frame p = in_frame(at, azimuth_direction(wall.azimuth_deg), x, y);
  const double end = std::abs(p.left) / (0.5 * wall.length_m);
  if (end >= 1.0 || p.along > 60.0 || p.along < -wall.back_m - 60.0) return 0.0;
  const double wobble =
      0.09 * wall.height_m * fractal_noise(x / 70.0, y / 70.0, 3, 0.45, seed + 41);
  const double behind = -p.along + std::clamp(wobble, -12.0, 12.0);
  const double step = smooth_side(behind / wall.run_m + 0.5);
  const double back = 1.0 - smooth_side((behind - 0.5 * wall.run_m) / wall.back_m);
  return wall.height_m * step * back * smooth_side((1.0 - end) / 0.35);
}

double fin_step(const FinShape& fin, Vec2d at, double x, double y, std::uint64_t seed) {
  const Frame p = in_frame(at, azimuth_direction(fin.azimuth_deg), x, y);
  const double end = std::abs(p.along) / (0.5 * fin.length_m);
  if (end >= 1.0 || std::abs(p.left) > fin.half_width_m + 20.0) return 0.0;
  const double wobble = 2.0 * gradient_noise(p.along / 17.0, 0.5, seed + 43);
  // Round on top, steep at the sides, running out at the foot: no edge sharper than a metre.
  const double u = (p.left + wobble) / (1.3 * fin.half_width_m);
  const double v = std::max(1.0 - u * u * u * u, 0.0);
  const double side = 1.2 * v * v / (v + 0.2);
  const double crest = 1.0 + 0.12 * fractal_noise(x / 13.0, y / 13.0, 2, 0.5, seed + 44);
  return fin.height_m * side * crest * smooth_side((1.0 - end) / 0.45);
}

/// Distance to a river's course and the water's height there.
double distance_to_river(const RiverShape& river, double x, double y, double& level,
                         std::uint64_t seed) {
  const double wx = x + 14.0 * fractal_noise(x / 170.0, y / 170.0, 2, 0.5, seed + 51);
  const double wy = y + 14.0 * fractal_noise(x / 170.0, y / 170.0, 2, 0.5, seed + 52);
  double best = 1e30, before = 0.0;
  for (std::size_t i = 1; i < river.course.size(); ++i) {
    const Vec2d a = river.course[i - 1], b = river.course[i];
    double t;
    const double d = distance_to_segment(a, b, wx, wy, t);
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    if (d < best) {
      best = d;
      level = river.level_m - 0.001 * river.fall_per_km_m * (before + t * length);
    }
    before += length;
  }
  return best;
}

/// Cuts the river's bed; returns how far inside its shore the place is, metres.
double cut_river(const RiverShape& river, double x, double y, double& h, std::uint64_t seed) {
  double level = 0.0;
  const double d = distance_to_river(river, x, y, level, seed);
  const double shore = 0.5 * river.width_m;
  // The surface stays flat for two metres beyond the shore: no beam meets a wet slope.
  h = std::lerp(level, h, smooth_side((d - shore - 2.0) / river.bank_m));
  return shore - d;
}

class GroundBuilder {
 public:
  GroundBuilder(const SceneDescription& scene, const Box2d& area, std::uint64_t seed, int threads,
                const std::filesystem::path& file)
      : scene_(scene), area_(area), seed_(mix_seed(seed)), threads_(threads), file_(file) {}

  std::unique_ptr<Ground> build() {
    shape_large();
    shape_fine();
    set_rock();
    GroundField& field = ground_->field;
    field.roughness = RoughnessVolume(seed_);
    field.beds = BedProfile(scene_.strata.thickness_m, seed_);
    const Vec2d dip = azimuth_direction(scene_.strata.dip_azimuth_deg);
    field.dip_x = tangent(scene_.strata.dip_deg) * dip.x;
    field.dip_y = tangent(scene_.strata.dip_deg) * dip.y;
    add_leans();
    add_voids();
    return std::move(ground_);
  }

 private:
  static std::uint64_t mix_seed(std::uint64_t seed) { return seed * 0x9e3779b97f4a7c15ULL + 1; }

  void shape_large() {
    Box2d whole = area_;
    for (const double side : {-0.5, 0.5})
      whole.add(side * scene_.size_m[0], side * scene_.size_m[1]);
    const double step = scene_.erosion.step_m;
    // A multiple of the coarsest erosion lattice, so that a small area sees the same nodes.
    const double block = 16.0 * step;
    whole = whole.grown(kErosionBorder);
    whole = {std::floor(whole.min_x / block) * block, std::floor(whole.min_y / block) * block,
             std::ceil(whole.max_x / block) * block, std::ceil(whole.max_y / block) * block};
    large_ = PlanField(lattice_over(whole, step));
    for_nodes(large_.lattice, threads_, [&](int i, int j) {
      large_.at(i, j) =
          static_cast<float>(large_shape(scene_, large_.lattice.x(i), large_.lattice.y(j), seed_));
    });
    erode(large_, scene_.erosion, seed_);
    for (RiverShape& river : scene_.rivers) {
      if (!std::isnan(river.level_m)) continue;
      river.level_m = std::numeric_limits<double>::infinity();
      for (const Vec2d p : river.course) {
        river.level_m = std::min(river.level_m, large_height(p.x, p.y) - 1.0);
      }
    }
  }

  /// The eroded ground, its place wavering: drainage on a lattice runs in eight directions, and
  /// straight gullies would show it.
  double large_height(double x, double y, double& gx, double& gy) const {
    const double wx = 9.0 * fractal_noise(x / 75.0, y / 75.0, 3, 0.45, seed_ + 71);
    const double wy = 9.0 * fractal_noise(x / 75.0, y / 75.0, 3, 0.45, seed_ + 72);
    return large_.value(x + wx, y + wy, gx, gy);
  }
  double large_height(double x, double y) const {
    double gx, gy;
    return large_height(x, y, gx, gy);
  }

  void shape_fine() {
    PlanField& height = ground_->field.height;
    height = PlanField(lattice_over(area_.grown(40.0), scene_.grid_m));
    if (!scene_.rivers.empty()) ground_->water = PlanField(lattice_over(area_.grown(8.0), 2.0));
    place_features(height.lattice);
    for_nodes(height.lattice, threads_, [&](int i, int j) {
      const double x = height.lattice.x(i), y = height.lattice.y(j);
      double gx, gy;
      double h = large_height(x, y, gx, gy);
      h += small_shape(scene_.detail, std::hypot(gx, gy), x, y, seed_);
      for (const auto& [wall, at] : walls_) h += wall_step(wall, at, x, y, seed_);
      for (const auto& [fin, at] : fins_) h += fin_step(fin, at, x, y, seed_);
      for (const RiverShape& river : scene_.rivers) cut_river(river, x, y, h, seed_);
      height.at(i, j) = static_cast<float>(h);
    });
    PlanField& water = ground_->water;
    if (scene_.rivers.empty()) return;
    for_nodes(water.lattice, threads_, [&](int i, int j) {
      double inside = -1e3, h = 0.0;
      for (const RiverShape& river : scene_.rivers) {
        inside =
            std::max(inside, cut_river(river, water.lattice.x(i), water.lattice.y(j), h, seed_));
      }
      water.at(i, j) = static_cast<float>(inside);
    });
  }

  void place_features(const PlanLattice& over) {
    const Box2d box{over.x0, over.y0, over.x(over.nx - 1), over.y(over.ny - 1)};
    for (const WallShape& wall : scene_.walls) {
      const double radius = wall.length_m + wall.back_m;
      for (const Vec2d at : repeated(wall.at, scene_.repeat_m, box.grown(radius))) {
        walls_.push_back({wall, at});
      }
    }
    for (const FinShape& fin : scene_.fins) {
      for (const Vec2d at : repeated(fin.at, scene_.repeat_m, box.grown(fin.length_m))) {
        fins_.push_back({fin, at});
      }
    }
  }

  void set_rock() {
    GroundField& field = ground_->field;
    field.rock_lattice = lattice_over(area_.grown(24.0), kRockStep);
    field.rock.resize(field.rock_lattice.size());
    for_nodes(field.rock_lattice, threads_, [&](int i, int j) {
      const double x = field.rock_lattice.x(i), y = field.rock_lattice.y(j);
      constexpr double kReach = 5.0;
      const PlanField& h = field.height;
      const double gx = (h.value(x + kReach, y) - h.value(x - kReach, y)) / (2.0 * kReach);
      const double gy = (h.value(x, y + kReach) - h.value(x, y - kReach)) / (2.0 * kReach);
      const double slope = std::hypot(gx, gy);
      const double steep = smooth_step(tangent(38.0), tangent(56.0), slope);
      const double start = scene_.strata.min_slope_deg;
      const double bedded = smooth_step(tangent(start), tangent(start + 12.0), slope);
      const double varied = 0.6 + 0.4 * gradient_noise(x / 75.0, y / 75.0, seed_ + 61);
      double rough = std::lerp(scene_.soil_roughness_m, scene_.rock_roughness_m,
                               smooth_step(tangent(30.0), tangent(48.0), slope));
      rough *= 1.0 + 0.35 * gradient_noise(x / 40.0, y / 40.0, seed_ + 62);
      double unused = 0.0;
      for (const RiverShape& river : scene_.rivers) {
        rough *= smooth_step(6.0, 14.0, -cut_river(river, x, y, unused, seed_));
      }
      RockNode& node = field.rock[field.rock_lattice.index(i, j)];
      const double scale = slope > 0.0 ? -steep / slope : 0.0;
      node = {static_cast<float>(gx * scale), static_cast<float>(gy * scale),
              static_cast<float>(rough),
              static_cast<float>(scene_.strata.depth_m * bedded * varied)};
    });
  }

  void add_leans() {
    for (const auto& [wall, at] : walls_) {
      if (wall.lean_m <= 0.0) continue;
      const Vec2d out = azimuth_direction(wall.azimuth_deg);
      Lean lean;
      lean.x = at.x, lean.y = at.y;
      lean.out_x = out.x, lean.out_y = out.y;
      lean.reach = wall.lean_m + wall.run_m;
      // Wide enough that the moved plan folds nowhere: the steepest fade is 1.875 reach / fade.
      lean.fade = 2.6 * lean.reach;
      lean.half_length = 0.28 * wall.length_m;
      lean.half_depth = wall.run_m + lean.reach;
      const double front = wall.run_m + 10.0;
      lean.foot = large_height(at.x + out.x * front, at.y + out.y * front) + 0.12 * wall.height_m;
      lean.top = lean.foot + 0.8 * wall.height_m;
      const double a = lean.half_length + lean.fade, d = lean.half_depth + lean.fade;
      for (const double u : {-1.0, 1.0}) {
        for (const double v : {-1.0, 1.0}) {
          lean.box.add(at.x + u * d * out.x - v * a * out.y, at.y + u * d * out.y + v * a * out.x);
        }
      }
      ground_->field.leans.push_back(lean);
    }
    ground_->field.prepare();
  }

  void add_voids() {
    std::vector<Void> voids;
    for (const auto& [fin, at] : fins_) {
      if (fin.hole_width_m <= 0.0 || fin.hole_height_m <= 0.0) continue;
      const Vec2d axis = azimuth_direction(fin.azimuth_deg + 90.0);
      const double outside = fin.half_width_m + 8.0;
      const double foot = std::max(large_height(at.x - axis.x * outside, at.y - axis.y * outside),
                                   large_height(at.x + axis.x * outside, at.y + axis.y * outside));
      voids.push_back(make_void(
          {at.x - axis.x * outside, at.y - axis.y * outside, foot + 0.36 * fin.hole_height_m}, axis,
          2.0 * outside, fin.hole_width_m, fin.hole_height_m));
    }
    for (const CaveShape& cave : scene_.caves) {
      const bool own_required = area_.contains(cave.at.x, cave.at.y);
      for (const Vec2d at : repeated(cave.at, scene_.repeat_m, area_)) {
        const bool own = at.x == cave.at.x && at.y == cave.at.y;
        if (!add_cave(cave, at, voids) && own && own_required) {
          throw InputError(file_.string(), "caves: no rock within 150 m behind [" +
                                               std::to_string(at.x) + ", " + std::to_string(at.y) +
                                               "]; move `at` in front of a steep face");
        }
      }
    }
    ground_->field.voids = std::move(voids);
    ground_->field.prepare();
  }

  bool add_cave(const CaveShape& cave, Vec2d at, std::vector<Void>& voids) const {
    const GroundField& field = ground_->field;
    const Vec2d out = azimuth_direction(cave.azimuth_deg);
    const double z = field.height.value(at.x, at.y) + cave.above_m;
    for (double d = 0.0; d < 150.0; d += 0.5) {
      const Vec3d p{at.x - d * out.x, at.y - d * out.y, z};
      if (field.value(p) > 0.0) continue;
      constexpr double kBefore = 4.0;
      voids.push_back(make_void({p.x + kBefore * out.x, p.y + kBefore * out.y, z}, {-out.x, -out.y},
                                cave.depth_m + kBefore, cave.width_m, cave.height_m));
      return true;
    }
    return false;
  }

  static Void make_void(Vec3d from, Vec2d axis, double length, double width, double height) {
    Void hole;
    hole.from = from;
    hole.axis = {axis.x, axis.y, 0.0};
    hole.length = length;
    hole.half_width = 0.5 * width;
    hole.half_height = 0.5 * height;
    hole.steepness = 3.0;
    const double margin = hole.half_width + 6.0;
    for (const double t : {0.0, length}) {
      const Vec3d p = from + hole.axis * t;
      hole.box.add(p - Vec3d{margin, margin, hole.half_height + 6.0});
      hole.box.add(p + Vec3d{margin, margin, hole.half_height + 6.0});
    }
    return hole;
  }

  SceneDescription scene_;
  Box2d area_;
  std::uint64_t seed_;
  int threads_;
  std::filesystem::path file_;
  std::unique_ptr<Ground> ground_ = std::make_unique<Ground>();
  PlanField large_;
  std::vector<std::pair<WallShape, Vec2d>> walls_;
  std::vector<std::pair<FinShape, Vec2d>> fins_;
};

}  // namespace

std::vector<Vec2d> repeated(Vec2d at, double repeat_m, const Box2d& area) {
  std::vector<Vec2d> places;
  if (repeat_m <= 0.0) {
    if (area.contains(at.x, at.y)) places.push_back(at);
    return places;
  }
  const auto first = [&](double low, double v) { return std::ceil((low - v) / repeat_m); };
  for (double j = first(area.min_y, at.y); at.y + j * repeat_m <= area.max_y; ++j) {
    for (double i = first(area.min_x, at.x); at.x + i * repeat_m <= area.max_x; ++i) {
      places.push_back({at.x + i * repeat_m, at.y + j * repeat_m});
    }
  }
  return places;
}

std::unique_ptr<Ground> build_ground(const SceneDescription& scene, const Box2d& area,
                                     std::uint64_t seed, int threads,
                                     const std::filesystem::path& file) {
  return GroundBuilder(scene, area, seed, threads, file).build();
}

}  // namespace cornice::simulate
