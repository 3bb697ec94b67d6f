// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <vector>

#include "core/base/error.h"
#include "core/cli/log.h"
#include "core/cli/options.h"
#include "core/cli/stage.h"
#include "stages/flightlines/lines_output.h"
#include "stages/flightlines/options.h"
#include "stages/flightlines/survey_lines.h"

namespace {

using namespace cornice;
namespace lines = cornice::flightlines;

void fill_report(const lines::SurveyLines& survey, Report& report) {
  report.count("points", survey.points);
  report.count("valid_points", survey.valid_points);
  report.count("lines", survey.lines.size());
  std::size_t by_source[3] = {0, 0, 0};
  for (const auto& estimate : survey.lines)
    ++by_source[static_cast<std::size_t>(estimate.line.beam_source)];
  report.count("lines_with_trajectory", by_source[0]);
  report.count("lines_with_angles", by_source[1]);
  report.count("lines_with_vertical_beams", by_source[2]);
  for (std::size_t i = 0; i < lines::kInvalidKinds; ++i)
    report.count(std::string("invalid_") + lines::invalid_name(static_cast<lines::Invalid>(i)),
                 survey.invalid[i]);
  report.quality("binning_points_per_s", static_cast<double>(survey.points) /
                                             (survey.binning_s + survey.estimate_s + 1e-9));
  for (const std::string& warning : survey.warnings) report.warn(warning);
  for (const std::string& warning : lines::step_downs(survey)) report.warn(warning);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::filesystem::path> tiles;
  std::filesystem::path output;
  lines::SurveyOptions options;
  Stage stage;
  stage.name = "flightlines";
  stage.description = "Splits a survey's points into flight lines and finds the sensor's path";
  stage.options = {
      Option("TILES", tiles, "LAS, LAZ or COPC files of one survey").positional().required(),
      output_option(output, "GeoPackage, .gpkg; a .json of the same name is written beside it")
          .ending(".gpkg")};
  stage.add(lines::describe_options(options), "Flight lines");
  stage.examples = {"cornice-flightlines tiles/*.laz -o lines.gpkg",
                    "cornice-flightlines tile.laz -o lines.gpkg --crs EPSG:2056+5728"};
  stage.run = [&](StageContext& context) {
    std::filesystem::path json = output;
    json.replace_extension(".json");
    check_output(json, context.options);
    options.threads = context.options.threads;
    for (const auto& tile : tiles) context.report.add_input(tile);
    lines::SurveyLines survey;
    context.report.step("lines", [&] {
      survey = lines::find_survey_lines(tiles, options, context.memory, context.progress);
    });
    context.report.step("writing", [&] {
      lines::write_json(json, survey);
      lines::write_geopackage(output, survey);
    });
    context.report.add_output(json);
    for (const std::string& line : lines::describe(survey)) log_info(line);
    fill_report(survey, context.report);
  };
  return run_stage(argc, argv, std::move(stage));
}
