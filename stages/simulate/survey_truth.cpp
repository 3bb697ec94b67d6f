// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/cli/version.h"
#include "core/io/ply.h"
#include "core/io/raster.h"
#include "stages/simulate/survey.h"

namespace cornice::simulate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kSummary = "truth/survey.json";
constexpr const char* kFormat = "cornice simulated survey";

ordered_json parameters_of(const Survey& survey) {
  SurveyOptions options = survey.options;
  ordered_json parameters;
  for (const auto& describe : {describe_scene, describe_flight, describe_scanner, describe_truth})
    for (const Option& option : describe(options)) parameters[option.name()] = option.value_text();
  return parameters;
}

ordered_json summary_of(const Survey& survey, const SurveyResult& result) {
  const SurveySetup& setup = survey.setup;
  const Box2d extent = setup.grid.extent();
  ordered_json files = ordered_json::array();
  for (const fs::path& file : result.files) files.push_back(file.generic_string());
  return {{"format", kFormat},
          {"version", 1},
          {"tool", "cornice-simulate " + version_text()},
          {"scene", setup.scene->name()},
          {"crs", crs_text(survey.options.product)},
          {"extent", {extent.min_x, extent.min_y, extent.max_x, extent.max_y}},
          {"defects", applied(setup.defects)},
          {"points", result.points},
          {"virtual_points", result.virtual_points},
          {"pulses", result.pulses},
          {"density", static_cast<double>(result.points) / (extent.width() * extent.height())},
          {"pulse_rate", setup.pulse_rate},
          {"altitude_m", survey.trajectory.altitude_m()},
          {"pass_spacing_m", survey.trajectory.pass_spacing_m()},
          {"ground_m",
           {{"lowest", survey.ground.lowest_m},
            {"mean", survey.ground.mean_m},
            {"highest", survey.ground.highest_m}}},
          {"parameters", parameters_of(survey)},
          {"files", files}};
}

void write_ground(const Survey& survey, const fs::path& folder, SurveyResult& result,
                  Progress& progress) {
  const SurveySetup& setup = survey.setup;
  const SurveyOptions& options = survey.options;
  const std::string crs = crs_text(options.product);
  for (int tile = 0; tile < setup.grid.count(); ++tile) {
    check_cancelled(progress);
    const Box2d box = setup.grid.tile(tile);
    if (options.truth_dem_step_m > 0.0) {
      Raster dem = setup.scene->ground_dem(options.truth_dem_step_m, box);
      dem.crs = crs_from_text(crs);
      const fs::path name =
          fs::path("truth") / dem_name(options.product, setup.grid, tile, options.year,
                                       options.truth_dem_step_m, setup.scene->name());
      write_cog(folder / name, dem);
      result.files.push_back(name);
    }
    if (options.truth_mesh_step_m > 0.0) {
      Mesh mesh = setup.scene->ground_mesh(options.truth_mesh_step_m, box);
      mesh.crs_text = crs;
      const fs::path name =
          fs::path("truth") / (tile_name(options.product, options.container, setup.grid, tile,
                                         options.year, setup.scene->name()) +
                               ".ground.ply");
      write_ply(folder / name, mesh);
      result.files.push_back(name);
    }
    progress.advance(1);
  }
}

}  // namespace

void write_survey_truth(const Survey& survey, const fs::path& folder, SurveyResult& result,
                        Progress& progress) {
  const SurveySetup& setup = survey.setup;
  const ScannerOptions& scanner = survey.options.scanner;
  const LinesHeader header{crs_text(survey.options.product),
                           scanner_name(scanner.pattern),
                           setup.pulse_rate,
                           scanner.field_of_view_deg(),
                           {scanner.tilt_deg, scanner.second_tilt_deg}};
  const std::vector<LineTruth> lines = line_truths(survey.trajectory, setup.lines, result.tallies,
                                                   setup.defects, survey.ground.mean_m);
  progress.begin("write truth", static_cast<std::uint64_t>(setup.grid.count()));
  write_lines_json(folder / "truth/lines.json", lines, header);
  write_lines_geopackage(folder / "truth/lines.gpkg", lines, header);
  write_trajectory_csv(folder / "truth/trajectory.csv", survey.trajectory, setup.defects);
  for (const char* name : {"truth/lines.json", "truth/lines.gpkg", "truth/trajectory.csv"})
    result.files.emplace_back(name);
  write_ground(survey, folder, result, progress);
  result.files.emplace_back(kSummary);
  write_file_atomically(folder / kSummary, summary_of(survey, result).dump(1) + "\n");
  progress.end();
}

void remove_earlier_survey(const fs::path& folder) {
  std::ifstream in(folder / kSummary, std::ios::binary);
  if (!in) return;
  const ordered_json summary = ordered_json::parse(in, nullptr, false);
  if (!summary.is_object() || summary.value("format", "") != kFormat) return;
  for (const auto& entry : summary.value("files", ordered_json::array())) {
    const fs::path file = entry.is_string() ? fs::path(entry.get<std::string>()) : fs::path();
    // A list that somebody changed must not reach out of the folder.
    const bool is_inside = !file.empty() && file.is_relative() &&
                           std::find(file.begin(), file.end(), "..") == file.end();
    std::error_code error;
    if (is_inside) fs::remove(folder / file, error);
    if (error) throw RunError((folder / file).string(), "cannot be removed: " + error.message());
  }
}

EmptyFolderRemover::EmptyFolderRemover(fs::path folder)
    : folder_(std::move(folder)), was_there_(fs::exists(folder_)) {}

EmptyFolderRemover::~EmptyFolderRemover() {
  // Folders with something in them are not removed: that is an error, and what is wanted.
  std::error_code error;
  fs::remove(folder_ / "truth", error);
  if (!was_there_) fs::remove(folder_, error);
}

}  // namespace cornice::simulate
