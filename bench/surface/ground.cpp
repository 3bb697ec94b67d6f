// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/surface/ground.h"

#include <cmath>
#include <utility>

#include "bench/programs.h"
#include "core/base/parallel.h"
#include "core/io/flight_lines_file.h"
#include "core/io/las.h"
#include "stages/normals/normals.h"
#include "stages/simulate/survey.h"

namespace cornice::bench {
namespace {

/// Neighbouring swaths cover each other by this part, and one line runs across: walls are met from
/// several sides, as where a survey is flown for them.
constexpr double kOverlapPercent = 60.0;

std::filesystem::path fly_tile(const GroundPlan& plan, const std::filesystem::path& folder,
                               int threads, Ground& ground) {
  simulate::SurveyOptions options;
  options.scene_file = plan.scene;
  options.seed = plan.seed;
  options.product = simulate::SurveyProduct::kLidarHd;
  options.tile_m = plan.size_m;
  options.density = plan.density;
  options.noise_m = plan.noise_m;
  options.overlap_percent = kOverlapPercent;
  options.flight.cross_line = true;
  options.truth = simulate::PointTruth::kNone;
  options.truth_dem_step_m = 0.0;
  check(options);
  ground.extent = tile_grid(options).extent();
  simulate::SceneOptions scene;
  scene.file = plan.scene;
  scene.seed = plan.seed;
  scene.extent = simulate::scene_extent(tile_grid(options));
  scene.threads = threads;
  ground.scene = simulate::Scene::build(scene);
  const simulate::Survey survey(options, *ground.scene);
  MemoryBudget memory;
  const simulate::SurveyResult flown = simulate::fly_survey(survey, folder, threads, memory);
  return folder / flown.files.front();
}

}  // namespace

Ground fly_ground(const GroundPlan& plan, const std::filesystem::path& programs,
                  const std::filesystem::path& folder, int threads) {
  Ground ground;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::filesystem::path tile = fly_tile(plan, folder / "survey", threads, ground);
  const std::filesystem::path lines = folder / "lines.gpkg";
  run_program({programs / "cornice-flightlines", tile, "-o", lines, "--threads",
               std::to_string(threads), "--no-progress"},
              folder / "flightlines.log");
  LasReadOptions read;
  read.attributes = normals::kAttributes;
  read.threads = threads;
  PointCloud points = read_las(read_las_info(tile), read).points;
  normals::Options options;
  options.threads = threads;
  const std::size_t count = points.size();
  normals::Result oriented =
      normals::compute_normals(std::move(points), count, read_flight_lines(lines),
                               normals::built_in_rules(normals::rules_for_file(tile)), options);
  ground.points.origin = oriented.origin;
  ground.points.positions = std::move(oriented.positions);
  ground.points.normals = std::move(oriented.normals);
  ground.points.quality = std::move(oriented.quality);
  std::filesystem::remove_all(folder);
  return ground;
}

OrientedPoints with_known(const Ground& ground, Known known, int threads) {
  constexpr std::size_t kGrain = 4096;
  OrientedPoints points = ground.points;
  const bool places = known == Known::kPlaces || known == Known::kBoth;
  const bool normals = known == Known::kNormals || known == Known::kBoth;
  if (!places && !normals) return points;
  parallel_for(points.positions.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const GroundPoint truth =
          nearest_ground(*ground.scene, points.origin + points.positions[p].cast<double>());
      if (!truth.found) continue;
      if (places) points.positions[p] = (truth.at - points.origin).cast<float>();
      if (normals) points.normals[p] = truth.normal.cast<float>();
    }
  });
  return points;
}

GroundPoint nearest_ground(const simulate::Scene& scene, Vec3d p) {
  constexpr int kSteps = 12;
  constexpr double kRestM = 1e-6;
  GroundPoint ground{p, {}, false};
  for (int step = 0; step < kSteps && !ground.found; ++step) {
    Vec3d gradient;
    const double value = scene.ground_value(ground.at, &gradient);
    const double square = dot(gradient, gradient);
    if (!(square > 0.0)) return ground;
    ground.normal = gradient / std::sqrt(square);
    const Vec3d move = gradient * (-value / square);
    ground.at += move;
    ground.found = norm(move) < kRestM;
  }
  return ground;
}

}  // namespace cornice::bench
