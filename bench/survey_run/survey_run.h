// SPDX-License-Identifier: GPL-3.0-or-later
// A simulated survey taken through `cornice run`, and what its stages reported.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace cornice::bench {

struct SurveyRunPlan {
  std::string scene = "alp";
  int tiles_a_side = 1;
  double tile_m = 1000.0;
  double density = 20.4;  ///< points/m²
  double halo_m = 40.0;
  std::uint64_t seed = 1;
  int threads = 2;
};

/// Of all jobs of one stage.
struct StageCost {
  double seconds = 0.0;      ///< wall clock, sum over the jobs
  double cpu_seconds = 0.0;  ///< of all threads, sum over the jobs
  double gib = 0.0;          ///< most resident memory of one job
  std::uint64_t jobs = 0;
};

struct SurveyRun {
  std::uint64_t points = 0;
  double wall_s = 0.0;  ///< of `cornice run`, its report included
  std::map<std::string, StageCost> stages;

  double seconds() const;      ///< of all jobs
  double cpu_seconds() const;  ///< of all jobs
  double gib() const;          ///< of the hungriest job
};

/// Flies the survey below `folder` (what is there is removed) and runs it with the programs beside
/// each other in `programs`. Throws RunError where something fails.
SurveyRun run_survey(const SurveyRunPlan& plan, const std::filesystem::path& programs,
                     const std::filesystem::path& scenes, const std::filesystem::path& folder);

}  // namespace cornice::bench
