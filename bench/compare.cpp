// SPDX-License-Identifier: GPL-3.0-or-later
// bench-compare: distances a second between a DEM and the surface that it is of, and how much of
// the overhangs that are there is found.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/compare/truth.h"
#include "bench/programs.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

constexpr double kMeshStepM = 0.5, kDemStepM = 0.5;

struct Own {
  std::vector<std::string> scenes{"alp", "cliff", "valley"};
  double tile_m = 0.0;  ///< 0: 200, or 60 with --quick
  double spacing_m = 0.25;
};

void body(const Own& own, const Options& options, Result& result) {
  const ScratchFolder folder("compare");
  const double tile_m = own.tile_m > 0.0 ? own.tile_m : options.quick ? 60.0 : 200.0;
  double slowest = 0.0, found = 1.0;
  for (const std::string& scene : own.scenes) {
    const TrueGround ground = true_ground(scene, tile_m, options.seed, options.threads);
    write_true_dem(ground, kDemStepM, folder / "dem.tif");
    write_true_surface(ground, kMeshStepM, folder / "mesh.ply");
    OverhangJudge judge(ground);
    compare::Options compared;
    compared.threads = options.threads;
    compared.spacing_m = own.spacing_m;
    const compare::Result r =
        compare_files(folder / "dem.tif", folder / "mesh.ply", compared,
                      [&](const compare::MeasuredPart& part) { judge.add(part); });
    double seconds = 0.0, measured = 0.0;
    for (const compare::Direction& d : r.directions) {
      seconds += d.seconds;
      measured += static_cast<double>(d.measured);
    }
    const double rate = measured / std::max(seconds, 1e-9);
    slowest = slowest == 0.0 ? rate : std::min(slowest, rate);
    result.figure("distances_per_s_" + scene, rate);
    result.figure("overhang_true_m2_" + scene, judge.true_m2());
    result.figure("overhang_listed_m2_" + scene, r.sides[1].overhang_m2);
    if (judge.true_m2() > 1.0) {
      result.figure("overhang_area_found_" + scene, judge.found_share());
      found = std::min(found, judge.found_share());
    }
    std::printf("%-8s %.0f distances in %.2f s; overhangs: %.1f m2 true, %.1f m2 in %zu listed\n",
                scene.c_str(), measured, seconds, judge.true_m2(), r.sides[1].overhang_m2,
                r.sides[1].overhangs.size());
  }
  result.figure("distances_per_s", slowest);
  result.figure("overhang_area_found", found);
  result.parameter("tile_m", tile_m);
  result.parameter("mesh_step_m", kMeshStepM);
  result.parameter("dem_step_m", kDemStepM);
  result.parameter("spacing_m", own.spacing_m);
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  return cornice::bench::run(
      "compare", "Distances a second, and overhangs found", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--scenes", own.scenes, "of samples/scenes")->delimiter(',');
        app.add_option("--tile-m", own.tile_m, "side of the ground, whole metres");
        app.add_option("--spacing-m", own.spacing_m, "of the samples");
      },
      [&](const Options& options, Result& result) { body(own, options, result); });
}
