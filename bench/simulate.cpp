// SPDX-License-Identifier: GPL-3.0-or-later
// How fast surveys are simulated and written, scene by scene, with the truth of every point.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "core/base/error.h"
#include "core/base/memory.h"
#include "stages/simulate/survey.h"

namespace cornice::bench {
namespace {

namespace fs = std::filesystem;
namespace sim = cornice::simulate;

constexpr double kDensity = 20.4;
constexpr double kQuickSideM = 150.0;

/// A scene and the side of the tile flown over it: as large as the scene is made for.
struct Case {
  const char* scene;
  double side_m;
};
constexpr Case kCases[] = {{"alp", 1000.0}, {"cliff", 400.0}, {"valley", 1000.0}, {"pass", 1000.0}};

struct Seconds {
  double build, plan, fly, truth;
  double all() const { return build + plan + fly + truth; }
};

/// One tile of LAZ with the truth as PLY and DEM, as cornice-simulate writes it by itself.
Seconds simulate(const Case& which, const Options& options, const fs::path& scratch,
                 std::uint64_t& points) {
  sim::SurveyOptions survey_options;
  survey_options.scene_file = fs::path(CORNICE_SCENES) / (std::string(which.scene) + ".yaml");
  survey_options.seed = options.seed;
  survey_options.tile_m = options.quick ? kQuickSideM : which.side_m;
  survey_options.density = kDensity;
  sim::check(survey_options);
  sim::SceneOptions scene_options;
  scene_options.file = survey_options.scene_file;
  scene_options.seed = options.seed;
  scene_options.extent = sim::scene_extent(sim::tile_grid(survey_options));
  scene_options.threads = options.threads;
  const ScratchFolder folder("simulate", scratch);
  fs::create_directories(folder / "truth");
  Seconds seconds{};
  std::unique_ptr<sim::Scene> scene;
  std::unique_ptr<sim::Survey> survey;
  sim::SurveyResult flown;
  MemoryBudget memory;
  seconds.build = seconds_of([&] { scene = sim::Scene::build(scene_options); });
  seconds.plan =
      seconds_of([&] { survey = std::make_unique<sim::Survey>(survey_options, *scene); });
  seconds.fly =
      seconds_of([&] { flown = sim::fly_survey(*survey, folder.path(), options.threads, memory); });
  seconds.truth = seconds_of([&] { sim::write_survey_truth(*survey, folder.path(), flown); });
  points = flown.points;
  return seconds;
}

void measure(const Options& options, const fs::path& scratch, const std::string& only,
             Result& result) {
  double least = std::numeric_limits<double>::infinity(), least_with_scene = least;
  for (const Case& which : kCases) {
    const std::string name = which.scene;
    if (!only.empty() && only != name) continue;
    std::uint64_t points = 0;
    const Seconds seconds = simulate(which, options, scratch, points);
    const auto count = static_cast<double>(points);
    result.figure("points_per_s_" + name, count / seconds.fly);
    result.figure("points_per_s_with_scene_" + name, count / seconds.all());
    result.figure("build_scene_s_" + name, seconds.build);
    result.parameter("points_" + name, static_cast<std::int64_t>(points));
    least = std::min(least, count / seconds.fly);
    least_with_scene = std::min(least_with_scene, count / seconds.all());
  }
  result.figure("points_per_s", least);
  result.figure("points_per_s_with_scene", least_with_scene);
  constexpr double kGib = 1024.0 * 1024.0 * 1024.0;
  result.figure("peak_memory_gib", static_cast<double>(peak_resident_bytes()) / kGib);
  result.parameter("density", kDensity);
}

}  // namespace
}  // namespace cornice::bench

int main(int argc, char** argv) {
  using namespace cornice;
  std::string scene;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
  return bench::run(
      "simulate",
      "Rates of simulating surveys of 20.4 points/m2 and writing them with their truth.", argc,
      argv,
      [&](CLI::App& app) {
        app.add_option("--scene", scene, "this sample scene alone")
            ->check(CLI::IsMember({"alp", "cliff", "valley", "pass"}));
        app.add_option("--scratch", scratch, "folder for the tiles, which are removed again")
            ->check(CLI::ExistingDirectory);
      },
      [&](const bench::Options& options, bench::Result& result) {
        bench::measure(options, scratch, scene, result);
      });
}
