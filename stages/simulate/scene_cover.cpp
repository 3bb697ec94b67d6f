// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_cover.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "stages/simulate/scene_noise.h"

namespace cornice::simulate {
namespace {

/// Key of a place that does not depend on the area covered.
std::uint64_t place_key(std::int64_t i, std::int64_t j) {
  return static_cast<std::uint64_t>(i) * 0x100000001b3ULL ^ static_cast<std::uint64_t>(j);
}

bool on_water(const Ground& ground, double x, double y, double margin_m) {
  return !ground.water.values.empty() && ground.water.value(x, y) > -margin_m;
}

bool place_house(const Ground& ground, House& house) {
  double low = 1e30, high = -1e30;
  const Vec2d left{-house.along.y, house.along.x};
  for (const double u : {-1.0, 0.0, 1.0}) {
    for (const double v : {-1.0, 0.0, 1.0}) {
      const double x =
          house.x + u * house.half_length * house.along.x + v * house.half_width * left.x;
      const double y =
          house.y + u * house.half_length * house.along.y + v * house.half_width * left.y;
      const double h = ground.field.height.value(x, y);
      low = std::min(low, h);
      high = std::max(high, h);
    }
  }
  if (high - low > 3.0 || on_water(ground, house.x, house.y, 15.0)) return false;
  house.foot = low - 2.0;
  house.eaves += high;
  house.ridge = house.eaves + 0.8 * house.half_width;
  return true;
}

}  // namespace

bool House::covers(double px, double py, double margin_m) const {
  const double dx = px - x, dy = py - y;
  return std::abs(dx * along.x + dy * along.y) < half_length + margin_m &&
         std::abs(-dx * along.y + dy * along.x) < half_width + margin_m;
}

std::vector<House> place_houses(const SceneDescription& scene, const Ground& ground,
                                const Box2d& area, std::uint64_t seed) {
  std::vector<House> houses;
  for (const VillageShape& village : scene.villages) {
    for (const Vec2d at : repeated(village.at, scene.repeat_m, area.grown(village.radius_m))) {
      const std::size_t first = houses.size();
      for (int n = 0; n < village.houses; ++n) {
        CounterRandom random(
            seed, 81,
            place_key(std::lround(at.x), std::lround(at.y)) * 1024 + static_cast<std::uint64_t>(n));
        // A few tries each; crowded or steep places stay empty.
        for (int attempt = 0; attempt < 12; ++attempt) {
          const double radius = village.radius_m * std::sqrt(random.uniform());
          const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
          House house;
          house.x = at.x + radius * std::cos(angle);
          house.y = at.y + radius * std::sin(angle);
          house.along = azimuth_direction(random.uniform(0.0, 360.0));
          house.half_length = random.uniform(5.5, 10.0);
          house.half_width = random.uniform(3.5, 5.5);
          house.eaves = random.uniform(2.8, 6.5);
          const bool crowded = std::any_of(
              houses.begin() + static_cast<std::ptrdiff_t>(first), houses.end(),
              [&](const House& o) { return std::hypot(o.x - house.x, o.y - house.y) < 26.0; });
          const bool inside = area.grown(-12.0).contains(house.x, house.y);
          if (crowded || !inside || !place_house(ground, house)) continue;
          houses.push_back(house);
          break;
        }
      }
    }
  }
  return houses;
}

HouseMesh mesh_houses(const std::vector<House>& houses) {
  //        r0 ------- r1        corners 0..3 counter-clockwise in plan, first at the foot,
  //       /  \       /  \       then at the eaves (4..7), then the ends of the ridge (8, 9)
  //      7    4 --- 5    6      ridge 8 over side 3-0, ridge 9 over side 1-2
  constexpr std::uint32_t kTriangles[14][3] = {
      {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4},
      {3, 4, 7}, {5, 6, 9}, {7, 4, 8}, {4, 5, 9}, {4, 9, 8}, {6, 7, 8}, {6, 8, 9}};
  HouseMesh mesh;
  for (const House& house : houses) {
    const Vec2d left{-house.along.y, house.along.x};
    const auto at = [&](double u, double v, double z) {
      return Vec3d{house.x + u * house.half_length * house.along.x + v * house.half_width * left.x,
                   house.y + u * house.half_length * house.along.y + v * house.half_width * left.y,
                   z};
    };
    std::array<Vec3d, 10> p{};
    for (std::size_t level = 0; level < 2; ++level) {
      const double z = level == 0 ? house.foot : house.eaves;
      p[4 * level] = at(-1, -1, z), p[4 * level + 1] = at(1, -1, z);
      p[4 * level + 2] = at(1, 1, z), p[4 * level + 3] = at(-1, 1, z);
    }
    p[8] = at(-1, 0, house.ridge);
    p[9] = at(1, 0, house.ridge);
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3d& corner : p) mesh.positions.push_back(corner.cast<float>());
    for (const auto& t : kTriangles) {
      mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
      mesh.faces.push_back({p[t[0]], normalized(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]))});
    }
  }
  return mesh;
}

std::vector<Tree> place_trees(const SceneDescription& scene, const Ground& ground,
                              const std::vector<House>& houses, const Box2d& area,
                              std::uint64_t seed) {
  const ForestShape& forest = scene.forest;
  std::vector<Tree> trees;
  if (forest.trees_per_ha <= 0.0) return trees;
  const double step = 100.0 / std::sqrt(forest.trees_per_ha);
  const double steepest = std::tan(forest.max_slope_deg * std::numbers::pi / 180.0);
  const auto cell = [&](double v) { return static_cast<std::int64_t>(std::floor(v / step)); };
  for (std::int64_t j = cell(area.min_y); j <= cell(area.max_y); ++j) {
    for (std::int64_t i = cell(area.min_x); i <= cell(area.max_x); ++i) {
      CounterRandom random(seed, 82, place_key(i, j));
      const double x = (static_cast<double>(i) + random.uniform()) * step;
      const double y = (static_cast<double>(j) + random.uniform()) * step;
      if (!area.contains(x, y)) continue;
      double gx, gy;
      const double h = ground.field.height.value(x, y, gx, gy);
      const double stand =
          0.5 + 0.9 * fractal_noise(x / forest.patch_m, y / forest.patch_m, 3, 0.5, seed + 83);
      const double high = smooth_step(forest.below_m - 60.0, forest.below_m, h);
      if (random.uniform(0.85, 1.15) * stand > forest.cover * (1.0 - high) + 0.15 * (0.5 - high)) {
        continue;
      }
      if (std::hypot(gx, gy) > steepest || on_water(ground, x, y, 3.0)) continue;
      const bool built = std::any_of(houses.begin(), houses.end(),
                                     [&](const House& house) { return house.covers(x, y, 5.0); });
      if (built) continue;
      const double size = random.uniform(0.55, 1.25) * (1.0 - 0.35 * high);
      const double height = forest.tree_height_m * size;
      Tree tree;
      tree.half_height = static_cast<float>(0.38 * height);
      tree.radius = static_cast<float>(forest.crown_radius_m * (0.45 + 0.55 * size));
      tree.middle = Vec3d{x, y, h + 0.6 * height}.cast<float>();
      trees.push_back(tree);
    }
  }
  return trees;
}

}  // namespace cornice::simulate
