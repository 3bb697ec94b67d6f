// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/orientation/survey.h"

#include <algorithm>

#include "bench/programs.h"
#include "core/base/error.h"
#include "core/io/flight_lines_file.h"
#include "core/io/las.h"
#include "core/io/ply.h"
#include "stages/normals/normals.h"

namespace cornice::bench {
namespace {

std::filesystem::path only_file(const std::filesystem::path& folder, const std::string& ending) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().string().ends_with(ending)) found.push_back(entry.path());
  }
  if (found.size() != 1) {
    throw RunError(folder.string(), "holds " + std::to_string(found.size()) + " files \"*" +
                                        ending + "\" instead of one");
  }
  return found.front();
}

std::filesystem::path scene_file(const std::string& scene,
                                 const std::vector<std::filesystem::path>& folders) {
  for (const std::filesystem::path& folder : folders) {
    const std::filesystem::path file = folder / (scene + ".yaml");
    if (std::filesystem::exists(file)) return file;
  }
  throw UsageError("--scenes", "there is no scene \"" + scene + "\"");
}

}  // namespace

std::string SurveyPlan::name() const {
  return scene + " " + scanner + (whole_degrees ? " whole" : " fine");
}

Survey fly(const SurveyPlan& plan, const std::filesystem::path& programs,
           const std::vector<std::filesystem::path>& scenes, const std::filesystem::path& folder,
           int threads) {
  std::filesystem::create_directories(folder);
  const std::filesystem::path survey = folder / "survey";
  std::filesystem::remove_all(survey);
  const std::string of_threads = std::to_string(threads);
  // The products differ in how they store the scan angle: point format 1 in whole degrees, point
  // format 6 in steps of 0.006.
  run_program({programs / "cornice-simulate",
               scene_file(plan.scene, scenes),
               "-o",
               survey,
               "--product",
               plan.whole_degrees ? "swisssurface3d" : "lidarhd",
               "--scanner",
               plan.scanner,
               "--tile-size",
               std::to_string(plan.tile_m),
               "--density",
               std::to_string(plan.density),
               "--noise",
               std::to_string(plan.noise_m),
               "--seed",
               std::to_string(plan.seed),
               "--truth-dem-step",
               "0",
               "--threads",
               of_threads,
               "--no-progress",
               "--overwrite"},
              folder / "simulate.log");
  Survey result;
  result.tile = only_file(survey, ".laz");
  std::filesystem::path lines = survey / "truth" / "lines.json";
  if (!plan.true_lines) {
    lines = folder / "lines.gpkg";
    run_program({programs / "cornice-flightlines", result.tile, "-o", lines, "--threads",
                 of_threads, "--no-progress", "--overwrite"},
                folder / "flightlines.log");
  }
  result.lines = read_flight_lines(lines);
  LasReadOptions read;
  read.attributes = normals::kAttributes;
  read.threads = threads;
  result.points = read_las(read_las_info(result.tile), read).points;
  result.truth = read_ply_points(only_file(survey / "truth", ".points.ply")).normals;
  if (result.truth.size() != result.points.size()) {
    throw RunError(result.tile.string(), "has another number of points than its truth");
  }
  return result;
}

}  // namespace cornice::bench
