// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-dem: DEM tiles in, meshes that meet at their borders out; or meshes in, a raster out.
#include "core/cli/stage.h"
#include "stages/dem/command.h"

int main(int argc, char** argv) {
  using namespace cornice;
  dem::Command command;
  Stage stage;
  stage.name = "dem";
  stage.description = "Makes meshes of DEM tiles that meet at their borders, or a raster of meshes";
  stage.options = dem::describe_meshing(command);
  stage.add(dem::describe_rastering(command), "The other way");
  stage.examples = {"cornice-dem swissalti3d_*.tif -o meshes",
                    "cornice-dem --from-mesh tiles/*.ply -o layers.tif --step 0.5"};
  stage.run = [&](StageContext& context) {
    dem::check_command(command);
    if (command.meshes.empty()) {
      dem::run_meshing(command, context);
    } else {
      dem::run_rastering(command, context);
    }
  };
  return run_stage(argc, argv, std::move(stage));
}
