// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/survey_run/survey_run.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/programs.h"

namespace cornice::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json read_json(const fs::path& path) {
  std::ifstream file(path);
  return json::parse(file);
}

void fly(const SurveyRunPlan& plan, const fs::path& programs, const fs::path& scenes,
         const fs::path& folder) {
  const std::string side = std::to_string(plan.tiles_a_side);
  run_program({programs / "cornice-simulate",
               scenes / (plan.scene + ".yaml"),
               "-o",
               folder / "survey",
               "--product",
               "lidarhd",
               "--tiles",
               side + "x" + side,
               "--tile-size",
               std::to_string(plan.tile_m),
               "--density",
               std::to_string(plan.density),
               "--noise",
               "0.03",
               "--seed",
               std::to_string(plan.seed),
               "--truth",
               "none",
               "--truth-dem-step",
               "0",
               "--no-progress",
               "--threads",
               std::to_string(plan.threads)},
              folder / "simulate.log");
}

/// From the records that `cornice run` keeps of its jobs.
std::map<std::string, StageCost> read_costs(const fs::path& state) {
  std::map<std::string, StageCost> costs;
  for (const auto& stage : fs::directory_iterator(state)) {
    StageCost& cost = costs[stage.path().filename().string()];
    for (const auto& entry : fs::directory_iterator(stage.path())) {
      const json record = read_json(entry.path());
      cost.seconds += record.at("seconds").get<double>();
      cost.cpu_seconds += record.at("cpu_seconds").get<double>();
      cost.gib = std::max(cost.gib, record.at("peak_memory_bytes").get<double>() / 0x1p30);
      ++cost.jobs;
    }
  }
  return costs;
}

}  // namespace

double SurveyRun::seconds() const {
  double sum = 0.0;
  for (const auto& [name, cost] : stages) sum += cost.seconds;
  return sum;
}

double SurveyRun::cpu_seconds() const {
  double sum = 0.0;
  for (const auto& [name, cost] : stages) sum += cost.cpu_seconds;
  return sum;
}

double SurveyRun::gib() const {
  double most = 0.0;
  for (const auto& [name, cost] : stages) most = std::max(most, cost.gib);
  return most;
}

SurveyRun run_survey(const SurveyRunPlan& plan, const fs::path& programs, const fs::path& scenes,
                     const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  fly(plan, programs, scenes, folder);
  const fs::path output = folder / "output";
  std::ofstream(folder / "survey.yaml") << "tiles: [survey]\noutput: output\nproduct: lidarhd\n"
                                        << "halo-m: " << plan.halo_m << "\n";
  SurveyRun run;
  run.wall_s =
      run_program({programs / "cornice", "run", folder / "survey.yaml", "--no-progress", "--until",
                   "stitch", "--jobs", "1", "--threads", std::to_string(plan.threads)},
                  folder / "run.log")
          .seconds;
  run.stages = read_costs(output / "state");
  const json survey = read_json(output / "survey.json");
  for (const json& tile : survey.at("tiles")) run.points += tile.at("points").get<std::uint64_t>();
  return run;
}

}  // namespace cornice::bench
