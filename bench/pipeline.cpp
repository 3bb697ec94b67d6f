// SPDX-License-Identifier: GPL-3.0-or-later
// bench-pipeline: what a survey of n x n tiles costs against n² times one tile.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "bench/survey_run/survey_run.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

void body(double tile_m, const Options& options, Result& result) {
  const ScratchFolder folder("pipeline");
  SurveyRunPlan plan;
  plan.tile_m = tile_m > 0.0 ? tile_m : options.quick ? 60.0 : 250.0;
  // In the proportion of whole tiles: a halo of 40 m around 250 m would double the points of a
  // tile.
  plan.halo_m = 0.04 * plan.tile_m;
  plan.seed = options.seed;
  plan.threads = options.threads;
  const SurveyRun one = run_survey(plan, CORNICE_BIN_DIR, CORNICE_SCENES, folder / "one");
  plan.tiles_a_side = options.quick ? 2 : 4;
  const SurveyRun many = run_survey(plan, CORNICE_BIN_DIR, CORNICE_SCENES, folder / "many");
  const int tiles = plan.tiles_a_side * plan.tiles_a_side;
  const std::string side = std::to_string(plan.tiles_a_side);
  result.parameter("tile_m", plan.tile_m);
  result.parameter("halo_m", plan.halo_m);
  result.parameter("points_one", static_cast<std::int64_t>(one.points));
  result.parameter("points_many", static_cast<std::int64_t>(many.points));
  result.figure("efficiency_" + side + "x" + side, many.wall_s / (tiles * one.wall_s));
  result.figure("stages_efficiency", many.seconds() / (tiles * one.seconds()));
  result.figure("cpu_efficiency", many.cpu_seconds() / (tiles * one.cpu_seconds()));
  result.figure("wall_seconds_one", one.wall_s);
  result.figure("wall_seconds_many", many.wall_s);
  result.figure("stage_gib_max_one", one.gib());
  result.figure("stage_gib_max", many.gib());
}

}  // namespace

int main(int argc, char** argv) {
  double tile_m = 0.0;
  return cornice::bench::run(
      "pipeline", "A survey of many tiles against as many times one tile", argc, argv,
      [&](CLI::App& app) { app.add_option("--tile-m", tile_m, "side of a tile, metres"); },
      [&](const Options& options, Result& result) { body(tile_m, options, result); });
}
