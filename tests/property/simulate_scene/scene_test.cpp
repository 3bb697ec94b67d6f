// SPDX-License-Identifier: GPL-3.0-or-later
// What must hold of every scene, on the sample scenes themselves (small pieces of them).
#include "stages/simulate/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/temporary_folder.h"

namespace cornice::simulate {
namespace {

constexpr double kEast = 2600000.0, kNorth = 1200000.0;

SceneOptions options_of(const std::string& name, double side_m, int threads = 0) {
  SceneOptions options;
  options.file = std::filesystem::path(CORNICE_SOURCE_DIR) / "samples/scenes" / (name + ".yaml");
  options.extent = {kEast - 0.5 * side_m, kNorth - 0.5 * side_m, kEast + 0.5 * side_m,
                    kNorth + 0.5 * side_m};
  options.threads = threads;
  return options;
}

/// Built once for all tests of this program.
const Scene& scene_of(const char* name) {
  static std::map<std::string, std::unique_ptr<Scene>> scenes;
  static const std::map<std::string, double> sides{
      {"alp", 220.0}, {"cliff", 260.0}, {"valley", 360.0}, {"pass", 280.0}};
  std::unique_ptr<Scene>& scene = scenes[name];
  if (scene == nullptr) scene = Scene::build(options_of(name, sides.at(name)));
  return *scene;
}

/// Airborne beams up to `lean` (tangent of the angle off the vertical), and beams from anywhere in
/// the air in any direction.
Ray random_ray(const Scene& scene, std::uint64_t n, bool airborne) {
  const Box3d box = scene.bounds();
  CounterRandom random(11, airborne ? 1 : 2, n);
  const Vec3d to{random.uniform(box.min.x, box.max.x), random.uniform(box.min.y, box.max.y),
                 random.uniform(box.min.z, box.max.z)};
  if (airborne) {
    const double height = box.max.z + 900.0 - to.z;
    const double lean = 0.7 * random.uniform(), turn = random.uniform(0.0, 6.2832);
    const Vec3d from{to.x + lean * height * std::cos(turn), to.y + lean * height * std::sin(turn),
                     to.z + height};
    return {from, normalized(to - from)};
  }
  Vec3d from;
  do {
    from = {random.uniform(box.min.x, box.max.x), random.uniform(box.min.y, box.max.y),
            random.uniform(box.min.z, box.max.z + 20.0)};
  } while (scene.ground_value(from) <= 0.01);
  Vec3d d;
  do {
    d = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  } while (dot(d, d) > 1.0 || dot(d, d) < 0.01);
  return {from, normalized(d)};
}

/// True where the ray runs through rock before `end` without having been stopped: F below zero by
/// more than what rounding and the least step explain.
bool passes_rock(const Scene& scene, const Ray& ray, double end, Vec3d& where) {
  const Box3d box = scene.bounds();
  const double start =
      ray.direction.z < 0.0 ? std::max(0.0, (box.max.z - ray.origin.z) / ray.direction.z) : 0.0;
  for (double t = start; t < end; t += 0.2) {
    const Vec3d p = ray.origin + ray.direction * t;
    if (!box.plan().contains(p.x, p.y)) continue;
    Vec3d gradient;
    const double value = scene.ground_value(p, &gradient);
    if (value < -2e-3 * norm(gradient)) {
      where = p;
      return true;
    }
  }
  return false;
}

class EveryScene : public ::testing::TestWithParam<const char*> {
 protected:
  const Scene& scene() const { return scene_of(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Samples, EveryScene, ::testing::Values("alp", "cliff", "valley", "pass"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST_P(EveryScene, HitsLieOnTheGroundAndTheirNormalsFaceTheBeam) {
  int hits = 0;
  for (std::uint64_t n = 0; n < 20000; ++n) {
    const Ray ray = random_ray(scene(), n, n % 2 == 0);
    Hit hit;
    if (!scene().cast(ray, hit)) continue;
    ++hits;
    ASSERT_NEAR(norm(hit.normal), 1.0, 1e-12);
    ASSERT_LT(dot(hit.normal, ray.direction), 0.0);
    ASSERT_LT(norm(hit.point - ray.origin - ray.direction * hit.range_m), 1e-6);
    if (hit.surface == SurfaceId::kHouse) continue;
    Vec3d gradient;
    const double value = scene().ground_value(hit.point, &gradient);
    const double slope = -dot(gradient, ray.direction) / norm(gradient);
    // Along the ray, where the ray is not so flat that a micrometre of height is more than that.
    ASSERT_LT(std::abs(value) / norm(gradient), 1e-6 * std::max(1.0, slope)) << "ray " << n;
    ASSERT_GT(dot(hit.normal, normalized(gradient)), 1.0 - 1e-6);
    ASSERT_EQ(hit.surface == SurfaceId::kOverhang, hit.normal.z < 0.0);
  }
  EXPECT_GT(hits, 9000);
}

TEST_P(EveryScene, BeamsCastTogetherHitWhereEachHitsAlone) {
  // Neighbours as in a scan line, and beams from anywhere to anywhere; no whole packet at the end.
  std::vector<Ray> rays;
  const Box3d box = scene().bounds();
  const Vec3d sensor{0.5 * (box.min.x + box.max.x), 0.5 * (box.min.y + box.max.y),
                     box.max.z + 900.0};
  for (int n = 0; n < 6000; ++n) {
    const Vec3d to{box.min.x + (box.max.x - box.min.x) * (n % 400) / 400.0,
                   box.min.y + (box.max.y - box.min.y) * (n / 400) / 15.0, box.min.z};
    rays.push_back({sensor, normalized(to - sensor)});
  }
  for (std::uint64_t n = 0; n < 4005; ++n) rays.push_back(random_ray(scene(), n, n % 2 == 0));
  std::vector<Hit> hits(rays.size());
  std::vector<std::uint8_t> met(rays.size(), 7);
  scene().cast_all(rays, hits, met);
  int count = 0, apart = 0;
  for (std::size_t n = 0; n < rays.size(); ++n) {
    Hit alone;
    const bool is_met = scene().cast(rays[n], alone);
    if (is_met != (met[n] == 1)) {
      ++apart;
      continue;
    }
    if (!is_met) continue;
    ++count;
    // Across the surface; along a ray that slides over it the same error is longer.
    if (std::abs(dot(alone.point - hits[n].point, alone.normal)) > 3e-6) {
      ++apart;
      continue;
    }
    ASSERT_EQ(hits[n].surface == SurfaceId::kHouse, alone.surface == SurfaceId::kHouse);
    ASSERT_GT(dot(alone.normal, hits[n].normal), 1.0 - 1e-6) << "ray " << n;
    ASSERT_LT(norm(hits[n].point - rays[n].origin - rays[n].direction * hits[n].range_m), 1e-6);
  }
  EXPECT_GT(count, 6000);
  EXPECT_LE(apart, 1);
}

TEST_P(EveryScene, ItsHeightBoundsHoldWhateverABeamHits) {
  const HeightBounds bounds = scene().height_bounds();
  for (std::uint64_t n = 0; n < 8000; ++n) {
    Hit hit;
    if (!scene().cast(random_ray(scene(), n, n % 2 == 0), hit)) continue;
    const HeightBounds::Range& range = bounds.at(hit.point.x, hit.point.y);
    ASSERT_GE(hit.point.z, static_cast<double>(range.low));
    ASSERT_LE(hit.point.z, static_cast<double>(range.high));
  }
}

TEST_P(EveryScene, HasAHeightEverywhere) {
  const Box2d extent = scene().bounds().plan();
  const Raster dem = scene().ground_dem(0.5, extent);
  int holes = 0;
  for (const float value : dem.values)
    if (!(value > dem.no_data + 1.0f)) ++holes;
  EXPECT_EQ(holes, 0);
}

TEST_P(EveryScene, GradientsAreThoseOfTheFunction) {
  const Box3d box = scene().bounds();
  for (std::uint64_t n = 0; n < 4000; ++n) {
    CounterRandom random(12, 3, n);
    const double x = random.uniform(box.min.x + 5, box.max.x - 5);
    const double y = random.uniform(box.min.y + 5, box.max.y - 5);
    const Vec3d p{x, y, scene().ground_height(x, y) + random.uniform(-6.0, 6.0)};
    Vec3d gradient;
    scene().ground_value(p, &gradient);
    constexpr double kStep = 2e-3;
    const auto slope = [&](Vec3d d) {
      return (scene().ground_value(p + d) - scene().ground_value(p - d)) / (2.0 * kStep);
    };
    const Vec3d numeric{slope({kStep, 0, 0}), slope({0, kStep, 0}), slope({0, 0, kStep})};
    ASSERT_LT(norm(numeric - gradient), 4e-3 * std::max(1.0, norm(gradient)))
        << "at " << p.x << " " << p.y << " " << p.z;
  }
}

TEST_P(EveryScene, NoBeamPassesRockBeforeItsHit) {
  int passed = 0, misses_through_rock = 0;
  Vec3d where;
  for (std::uint64_t n = 0; n < 4000; ++n) {
    const Ray ray = random_ray(scene(), n, n % 4 != 0);
    Hit hit;
    const bool met = scene().cast(ray, hit);
    const double end = met ? hit.range_m - 1e-3 : 3000.0;
    if (!passes_rock(scene(), ray, end, where)) continue;
    ++(met ? passed : misses_through_rock);
    const Box2d inner = scene().bounds().plan().grown(-30.0);
    EXPECT_FALSE(inner.contains(where.x, where.y))
        << "ray " << n << (met ? " hit behind rock at " : " missed rock at ") << where.x - kEast
        << " " << where.y - kNorth << " " << where.z;
  }
  // Only beams that come in under the border, where the ground beyond is not known.
  EXPECT_LT(passed, 40);
  EXPECT_LT(misses_through_rock, 400);
}

TEST_P(EveryScene, HardlyAnyBeamIsGivenUp) {
  const std::uint64_t before = scene().grazing_misses();
  for (std::uint64_t n = 0; n < 20000; ++n) {
    Hit hit;
    scene().cast(random_ray(scene(), n + 500000, true), hit);
  }
  EXPECT_LE(scene().grazing_misses() - before, 2u);
}

TEST_P(EveryScene, TheDemHoldsTheTopOfBeamsFromAbove) {
  const Box3d box = scene().bounds();
  const Box2d window{box.min.x + 10, box.min.y + 20, box.min.x + 110, box.min.y + 80};
  const Raster dem = scene().ground_dem(2.0, window);
  ASSERT_EQ(dem.width, 50);
  ASSERT_EQ(dem.height, 30);
  for (int row = 0; row < dem.height; row += 3) {
    for (int col = 0; col < dem.width; ++col) {
      const double x = dem.west + (col + 0.5) * 2.0, y = dem.north - (row + 0.5) * 2.0;
      Hit hit;
      ASSERT_TRUE(scene().cast({{x, y, box.max.z + 500.0}, {0, 0, -1}}, hit));
      if (hit.surface == SurfaceId::kHouse) {
        EXPECT_LT(dem.at(col, row), hit.point.z);
        continue;
      }
      EXPECT_NEAR(dem.at(col, row), hit.point.z, 2e-4);
      EXPECT_NEAR(scene().ground_height(x, y), hit.point.z, 1e-5);
    }
  }
}

/// Every edge has two triangles, or one where both its ends lie on one side of the window; around
/// every vertex the triangles form one fan.
void expect_manifold(const Mesh& mesh, const Box2d& window) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  std::vector<int> corners(mesh.positions.size(), 0);
  std::vector<std::map<std::uint32_t, std::uint32_t>> around(mesh.positions.size());
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      ASSERT_NE(a, b);
      ASSERT_EQ(directed[std::make_pair(a, b)]++, 0) << "an edge is used twice one way";
      ++corners[a];
      around[a][b] = c;
    }
  }
  const auto sides = [&](std::uint32_t v) {
    const Vec3d p = mesh.origin + mesh.positions[v].cast<double>();
    constexpr double kNear = 2e-4;
    return (std::abs(p.x - window.min_x) < kNear ? 1 : 0) |
           (std::abs(p.x - window.max_x) < kNear ? 2 : 0) |
           (std::abs(p.y - window.min_y) < kNear ? 4 : 0) |
           (std::abs(p.y - window.max_y) < kNear ? 8 : 0);
  };
  for (const auto& [edge, count] : directed) {
    if (directed.contains({edge.second, edge.first})) continue;
    ASSERT_NE(sides(edge.first) & sides(edge.second), 0) << "an open edge within the window";
  }
  for (std::size_t v = 0; v < around.size(); ++v) {
    if (around[v].empty()) continue;
    // Start at a border edge where there is one.
    std::uint32_t start = around[v].begin()->first;
    for (const auto& [from, to] : around[v]) {
      bool entered = false;
      for (const auto& [f, t] : around[v]) entered = entered || t == from;
      if (!entered) start = from;
    }
    int walked = 0;
    for (std::uint32_t at = start; walked <= corners[v];) {
      const auto next = around[v].find(at);
      if (next == around[v].end()) break;
      ++walked;
      at = next->second;
      if (at == start) break;
    }
    ASSERT_EQ(walked, corners[v]) << "vertex " << v << " has more than one fan";
  }
}

TEST_P(EveryScene, TheTruthMeshIsAManifoldOnTheGround) {
  const Box3d box = scene().bounds();
  const Box2d window{box.min.x + 20.0, box.min.y + 30.0, box.max.x - 15.0, box.max.y - 20.0};
  const Mesh mesh = scene().ground_mesh(1.0, window);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_EQ(mesh.byte_properties.size(), 1u);
  EXPECT_EQ(mesh.byte_properties[0].name, "surface");
  expect_manifold(mesh, window);
  Box3d reached;
  double plan_area = 0.0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d p = mesh.origin + mesh.positions[v].cast<double>();
    reached.add(p);
    Vec3d gradient;
    const double value = scene().ground_value(p, &gradient);
    ASSERT_LT(std::abs(value) / norm(gradient), 1e-4)
        << "vertex at " << p.x - kEast << " " << p.y - kNorth << " " << p.z;
    ASSERT_GT(dot(mesh.normals[v].cast<double>(), normalized(gradient)), 1.0 - 1e-5);
    ASSERT_EQ(mesh.byte_properties[0].values[v] == static_cast<std::uint8_t>(SurfaceId::kOverhang),
              mesh.normals[v].z < 0.0f);
  }
  for (const auto& t : mesh.triangles) {
    const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    plan_area += 0.5 * static_cast<double>((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
  }
  // Signed by the winding: overhangs count against what covers them.
  EXPECT_NEAR(plan_area, window.width() * window.height(), 0.5);
  EXPECT_NEAR(reached.min.x, window.min_x, 1e-3);
  EXPECT_NEAR(reached.max.y, window.max_y, 1e-3);
}

/// Area of the mesh whose faces look down, m².
double overhang_area(const Scene& scene, double step_m) {
  const Mesh mesh = scene.ground_mesh(step_m, scene.bounds().plan());
  double area = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.positions[t[0]].cast<double>();
    const Vec3d n =
        cross(mesh.positions[t[1]].cast<double>() - a, mesh.positions[t[2]].cast<double>() - a);
    if (n.z < 0.0) area += 0.5 * norm(n);
  }
  return area;
}

TEST(CliffScene, HasThousandsOfSquareMetresOfOverhang) {
  const double area = overhang_area(scene_of("cliff"), 1.0);
  RecordProperty("overhang_m2", std::to_string(area));
  EXPECT_GT(area, 3000.0);
}

TEST(ValleyScene, HasNoOverhang) { EXPECT_EQ(overhang_area(scene_of("valley"), 1.0), 0.0); }

TEST(CliffScene, BeamsPassUnderAndOverTheArch) {
  const Scene& scene = scene_of("cliff");
  const double x = kEast - 45.0, y = kNorth - 45.0;  // where the scene file puts it
  Hit top, under, through;
  ASSERT_TRUE(scene.cast({{x, y, 3000.0}, {0, 0, -1}}, top));
  // From the air below the arch, upwards, onto its underside.
  const double foot = scene.ground_height(x - 1.7, y - 22.0);
  const Vec3d inside{x, y, foot + 9.0};
  ASSERT_GT(scene.ground_value(inside), 0.0);
  ASSERT_TRUE(scene.cast({inside, {0, 0, 1}}, under));
  EXPECT_EQ(under.surface, SurfaceId::kOverhang);
  EXPECT_LT(under.point.z, top.point.z - 2.0);
  EXPECT_GT(top.point.z, foot + 20.0);
  // Level, along the axis of the hole: nothing within 15 m either way.
  const double azimuth = (80.0 + 90.0) * 3.14159265358979 / 180.0;
  const Vec3d axis{std::sin(azimuth), std::cos(azimuth), 0.0};
  for (const double way : {1.0, -1.0}) {
    const bool met = scene.cast({inside, axis * way}, through);
    EXPECT_TRUE(!met || through.range_m > 15.0) << through.range_m;
  }
}

TEST(CliffScene, TheCaveGoesIntoTheWall) {
  const Scene& scene = scene_of("cliff");
  const double x = kEast + 70.0;
  const double z = scene.ground_height(x, kNorth) + 7.0;
  Hit cave, beside;
  ASSERT_TRUE(scene.cast({{x, kNorth, z}, {0, 1, 0}}, cave));
  ASSERT_TRUE(scene.cast({{x - 22.0, kNorth, z}, {0, 1, 0}}, beside));
  EXPECT_GT(cave.range_m, beside.range_m + 12.0);
  Hit roof;
  ASSERT_TRUE(scene.cast({cave.point - Vec3d{0, 4.0, 0}, {0, 0, 1}}, roof));
  EXPECT_EQ(roof.surface, SurfaceId::kOverhang);
}

TEST(ValleyScene, HasWaterHousesAndTrees) {
  const Scene& scene = scene_of("valley");
  const Box3d box = scene.bounds();
  int water = 0, house = 0, wooded = 0;
  for (std::uint64_t n = 0; n < 40000; ++n) {
    CounterRandom random(13, 4, n);
    const Ray ray{{random.uniform(box.min.x, box.max.x), random.uniform(box.min.y, box.max.y),
                   box.max.z + 100.0},
                  {0, 0, -1}};
    Hit hit;
    ASSERT_TRUE(scene.cast(ray, hit));
    CanopyPassage passage;
    if (scene.canopy(ray, hit.range_m, passage)) {
      ++wooded;
      ASSERT_LT(passage.enter_m, passage.exit_m);
      ASSERT_LE(passage.exit_m, hit.range_m);
      ASSERT_GT(passage.density, 0.0);
    }
    if (hit.surface == SurfaceId::kHouse) ++house;
    if (hit.surface != SurfaceId::kWater) continue;
    ++water;
    EXPECT_GT(hit.normal.z, 0.999);
  }
  EXPECT_GT(water, 400);
  EXPECT_GT(house, 50);
  EXPECT_GT(wooded, 2000);
  EXPECT_GT(scene.trees(), 500u);
  EXPECT_GT(scene.houses(), 3u);
}

TEST(Scene, IsTheSameWithOneAndTwoThreadsAndWhatTheSeedSays) {
  SceneOptions options = options_of("cliff", 120.0, 1);
  const auto one = Scene::build(options);
  options.threads = 2;
  const auto two = Scene::build(options);
  options.seed = 2;
  const auto other = Scene::build(options);
  const Mesh a = one->ground_mesh(1.0, options.extent);
  const Mesh b = two->ground_mesh(1.0, options.extent);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_NE(other->ground_mesh(1.0, options.extent).positions, a.positions);
  for (std::uint64_t n = 0; n < 2000; ++n) {
    const Ray ray = random_ray(*one, n, true);
    Hit p, q;
    ASSERT_EQ(one->cast(ray, p), two->cast(ray, q));
    ASSERT_EQ(p.point, q.point);
    ASSERT_EQ(p.normal, q.normal);
  }
}

TEST(Scene, APieceIsThatPieceOfTheWhole) {
  const auto small = Scene::build(options_of("alp", 120.0));
  const Scene& large = scene_of("alp");
  for (std::uint64_t n = 0; n < 1000; ++n) {
    CounterRandom random(14, 5, n);
    const double x = kEast + random.uniform(-50, 50), y = kNorth + random.uniform(-50, 50);
    EXPECT_NEAR(small->ground_height(x, y), large.ground_height(x, y), 1e-4);
  }
}

TEST(Scene, TheMeshThatGuidesTheRaysDoesNotChangeTheHits) {
  SceneOptions options = options_of("cliff", 200.0);
  options.mesh_step_m = 0.5;
  const auto fine = Scene::build(options);
  options.mesh_step_m = 1.0;
  const auto coarse = Scene::build(options);
  int met_by_one = 0, far_apart = 0;
  for (std::uint64_t n = 0; n < 5000; ++n) {
    const Ray ray = random_ray(*fine, n, true);
    Hit p, q;
    const bool a = fine->cast(ray, p), b = coarse->cast(ray, q);
    if (a != b) ++met_by_one;
    if (!a || !b) continue;
    // Across the surface; along a ray that slides over it the same error is longer.
    if (std::abs(dot(p.point - q.point, p.normal)) > 3e-6) ++far_apart;
  }
  EXPECT_LE(met_by_one, 1);
  EXPECT_LE(far_apart, 1);
}

TEST(Scene, RefusesAnImpossibleExtentOrWindow) {
  SceneOptions options = options_of("cliff", 120.0);
  options.extent = {0, 0, 5, 100};
  EXPECT_THROW(Scene::build(options), UsageError);
  options.extent = {};
  EXPECT_THROW(Scene::build(options), UsageError);
  const Scene& scene = scene_of("cliff");
  EXPECT_THROW(scene.ground_mesh(1.0, {0, 0, 10, 10}), UsageError);
  EXPECT_THROW(scene.ground_dem(1.0, {}), UsageError);
  // The option that the message names is one of the program's.
  const Box2d window{kEast, kNorth, kEast + 10.0, kNorth + 10.0};
  try {
    scene.ground_mesh(0.0, window);
    FAIL() << "no error";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("--truth-mesh-step"));
  }
  EXPECT_TRUE(std::isnan(scene.ground_height(0.0, 0.0)));
}

TEST(Scene, ACaveWithoutAFaceIsAnErrorThatNamesTheFile) {
  const test::TemporaryFolder folder;
  const auto file = folder / "scene_cave_nowhere.yaml";
  test::write_text(file,
                   "cornice_scene: 1\nname: x\nbase_m: 0\nsize_m: {east: 60, north: 60}\n"
                   "caves:\n  - {at: [0, 0], azimuth_deg: 0, above_m: 5, width_m: 6, "
                   "height_m: 6, depth_m: 9}\n");
  SceneOptions options = options_of("cliff", 60.0);
  options.file = file;
  try {
    Scene::build(options);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::AllOf(::testing::HasSubstr("scene_cave_nowhere.yaml"),
                                               ::testing::HasSubstr("caves")));
  }
}

TEST(Scene, BeamsThatAreNoNumbersMeetNothing) {
  Hit hit;
  EXPECT_FALSE(scene_of("cliff").cast({{std::nan(""), 0, 0}, {0, 0, -1}}, hit));
  EXPECT_FALSE(scene_of("cliff").cast({{kEast, kNorth, 3000}, {0, 0, std::nan("")}}, hit));
}

}  // namespace
}  // namespace cornice::simulate
