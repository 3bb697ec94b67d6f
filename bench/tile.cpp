// SPDX-License-Identifier: GPL-3.0-or-later
// bench-tile: one simulated tile from LAZ to the stitched mesh, by `cornice run`.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "bench/survey_run/survey_run.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

struct Own {
  std::string scene = "alp";
  double tile_m = 0.0;  ///< 0: 1000, or 200 with --quick
};

void body(const Own& own, const Options& options, Result& result) {
  const ScratchFolder folder("tile");
  SurveyRunPlan plan;
  plan.scene = own.scene;
  plan.tile_m = own.tile_m > 0.0 ? own.tile_m : options.quick ? 200.0 : 1000.0;
  plan.seed = options.seed;
  plan.threads = options.threads;
  const SurveyRun run = run_survey(plan, CORNICE_BIN_DIR, CORNICE_SCENES, folder / "run");
  result.parameter("scene", plan.scene);
  result.parameter("tile_m", plan.tile_m);
  result.parameter("points", static_cast<std::int64_t>(run.points));
  result.figure("seconds", run.seconds());
  result.figure("cpu_seconds", run.cpu_seconds());
  result.figure("wall_seconds", run.wall_s);
  result.figure("gib", run.gib());
  for (const auto& [name, cost] : run.stages) {
    result.figure("seconds_" + name, cost.seconds);
    result.figure("cpu_seconds_" + name, cost.cpu_seconds);
    result.figure("gib_" + name, cost.gib);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  return cornice::bench::run(
      "tile", "One simulated tile from LAZ to the stitched mesh, stage by stage", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--scene", own.scene, "of samples/scenes");
        app.add_option("--tile-m", own.tile_m, "side of the tile, metres");
      },
      [&](const Options& options, Result& result) { body(own, options, result); });
}
