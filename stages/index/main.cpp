// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-index: the tiles of a survey in, how they lie beside each other out.
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/cli/log.h"
#include "core/cli/stage.h"
#include "stages/index/survey_index.h"

namespace {

using namespace cornice;

std::vector<Option> describe(index::IndexOptions& o) {
  return {
      Option("crs", o.crs, "replaces the CRS of the files, such as EPSG:2056+5728"),
      Option("step-m", o.step_m, "of the survey's lattice").range(0.05, 10).unit("m"),
      Option("halo-m", o.halo_m, "tiles nearer than this are neighbours").range(0, 500).unit("m"),
      Option("seam-m", o.seam_m, "borders no further apart than this are one")
          .range(0, 50)
          .unit("m")};
}

void run(const std::vector<std::filesystem::path>& tiles, const index::IndexOptions& options,
         const std::filesystem::path& output, StageContext& context) {
  for (const auto& tile : tiles) context.report.add_input(tile);
  index::SurveyIndex survey;
  context.report.step("headers",
                      [&] { survey = index::index_survey(tiles, options, context.progress); });
  write_file_atomically(output, index::to_json(survey));
  std::uint64_t points = 0, unusable = 0;
  for (const index::IndexedTile& tile : survey.tiles) {
    if (tile.problem.empty()) {
      points += tile.points;
      continue;
    }
    ++unusable;
    context.report.warn(tile.path.string() + ": " + tile.problem);
  }
  for (const std::string& warning : survey.warnings) context.report.warn(warning);
  context.report.count("tiles", survey.tiles.size());
  context.report.count("unusable_tiles", unusable);
  context.report.count("points", points);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::filesystem::path> tiles;
  std::filesystem::path output;
  index::IndexOptions options;
  Stage stage;
  stage.name = "index";
  stage.description = "Lays out the tiles of a survey from their headers: borders and neighbours";
  stage.options = {
      Option("TILES", tiles, "LAS, LAZ or COPC files of one survey").positional().required(),
      output_option(output, "index of the survey, .json")};
  stage.add(describe(options), "Layout");
  stage.examples = {"cornice-index tiles/*.laz -o survey.json",
                    "cornice-index tiles/*.las.zip -o survey.json --crs EPSG:2056+5728"};
  stage.run = [&](StageContext& context) { run(tiles, options, output, context); };
  return run_stage(argc, argv, std::move(stage));
}
