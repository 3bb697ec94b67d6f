// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-viewer: looks at hierarchies, in a window or into pictures.
#include <algorithm>
#include <string_view>

#include "core/cli/stage.h"
#include "terrain-viewer/app/headless.h"
#include "terrain-viewer/app/settings.h"
#include "terrain-viewer/app/window.h"

int main(int argc, char** argv) {
  using namespace cornice;
  viewer::Options options;
  // Pictures depend on the command line alone.
  const bool is_headless =
      std::find(argv, argv + argc, std::string_view("--headless")) != argv + argc;
  viewer::SettingsRead settings;
  if (!is_headless) {
    settings = viewer::read_settings(viewer::settings_path());
    viewer::apply(settings.settings, options);
  }
  Stage stage;
  stage.name = "viewer";
  stage.description = "Draws terrain from hierarchies of any size";
  stage.options = viewer::describe(options);
  stage.examples = {"cornice-viewer survey.hlod",
                    "cornice-viewer survey.hlod --headless -o overview.png",
                    "cornice-viewer survey.hlod --headless --path flight.json -o frame_%04d.png"};
  stage.run = [&](StageContext& context) {
    if (options.headless)
      viewer::run_headless(options, context.report, context.progress);
    else
      viewer::run_window(options, std::move(settings), context.report, context.progress);
  };
  return run_stage(argc, argv, std::move(stage));
}
