// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cornice-dem.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/stage.h"
#include "stages/dem/survey.h"

namespace cornice::dem {

/// Everything the command line says.
struct Command {
  std::vector<std::filesystem::path> tiles;
  std::vector<std::filesystem::path> only;    ///< of the tiles; empty: all
  std::vector<std::filesystem::path> meshes;  ///< --from-mesh
  std::filesystem::path output;               ///< folder of meshes, or one raster
  std::string format = "ply";
  int tile_pixels = 2048;
  SurveyOptions survey;
  std::optional<double> step_m;  ///< of the raster made of meshes
  std::filesystem::path like;    ///< raster whose grid it gets
};

/// Options of `command`, which must stay where it is.
std::vector<Option> describe_meshing(Command& command);
std::vector<Option> describe_rastering(Command& command);

/// Throws UsageError for options that do not go together and for tiles whose meshes would have one
/// name.
void check_command(const Command& command);

/// DEM tiles to meshes.
void run_meshing(const Command& command, StageContext& context);
/// Meshes to a raster of their layers.
void run_rastering(const Command& command, StageContext& context);

}  // namespace cornice::dem
