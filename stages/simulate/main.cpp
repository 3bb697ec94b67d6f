// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>

#include "core/cli/stage.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/survey.h"

namespace {

using namespace cornice;
using namespace cornice::simulate;

void run(const SurveyOptions& options, const std::filesystem::path& folder, StageContext& context) {
  check(options);
  Report& report = context.report;
  report.add_input(options.scene_file);
  SceneOptions scene_options;
  scene_options.file = options.scene_file;
  scene_options.seed = options.seed;
  scene_options.extent = scene_extent(tile_grid(options));
  scene_options.threads = context.options.threads;
  std::unique_ptr<Scene> scene;
  report.step("build scene", [&] { scene = Scene::build(scene_options); });
  std::unique_ptr<Survey> survey;
  report.step("plan flight", [&] { survey = std::make_unique<Survey>(options, *scene); });
  const EmptyFolderRemover remover(folder);
  remove_earlier_survey(folder);
  SurveyResult result;
  report.step("fly and write tiles", [&] {
    result = fly_survey(*survey, folder, context.options.threads, context.memory, context.progress);
  });
  report.step("write truth",
              [&] { write_survey_truth(*survey, folder, result, context.progress); });
  report.count("points", result.points);
  report.count("pulses", result.pulses);
  report.count("virtual points", result.virtual_points);
  report.count("lines", survey->setup.lines.size());
  report.count("tiles", result.points_of_tile.size());
  const Box2d extent = survey->setup.grid.extent();
  report.quality("density",
                 static_cast<double>(result.points) / (extent.width() * extent.height()));
  for (std::size_t tile = 0; tile < result.points_of_tile.size(); ++tile)
    if (result.points_of_tile[tile] == 0)
      report.warn("tile " + result.files[tile].string() + " got no points");
}

}  // namespace

int main(int argc, char** argv) {
  SurveyOptions options;
  std::filesystem::path folder;
  Stage stage;
  stage.name = "simulate";
  stage.description = "Flies an airborne laser scanner over a scene and writes tiles and the truth";
  stage.options = {
      Option("SCENE", options.scene_file, "scene description, .yaml").positional().required(),
      output_option(folder, "folder of the tiles; the truth goes into its folder truth")};
  stage.add(describe_scene(options), "Tiles");
  stage.add(describe_flight(options), "Flight");
  stage.add(describe_scanner(options), "Scanner");
  stage.add(describe_truth(options), "Truth");
  stage.examples = {
      "cornice-simulate samples/scenes/cliff.yaml -o survey --tile-size 200 --density 20",
      "cornice-simulate samples/scenes/alp.yaml -o survey --product lidarhd --scanner palmer"};
  stage.run = [&](StageContext& context) { run(options, folder, context); };
  return run_stage(argc, argv, std::move(stage));
}
