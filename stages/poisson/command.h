// SPDX-License-Identifier: GPL-3.0-or-later
// What cornice-poisson does with files: solve, extract, mesh.
#pragma once

#include <filesystem>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/stage.h"
#include "stages/poisson/band.h"
#include "stages/poisson/extract.h"
#include "stages/poisson/fill.h"
#include "stages/poisson/solve.h"
#include "stages/poisson/support.h"

namespace cornice::poisson {

/// Everything the command line can say; each action uses a part of it.
struct Command {
  std::string action;
  std::filesystem::path points;
  std::filesystem::path field;
  std::filesystem::path output;
  std::filesystem::path band;  ///< empty: beside the field, ending in .band
  std::vector<std::filesystem::path> neighbours;
  std::filesystem::path tile_list;
  std::vector<double> tile;  ///< west, south, east, north; empty: the points' own box
  double halo_m = 40.0;      ///< points farther from the tile are not used
  double band_m = 8.0;       ///< on either side of a border
  double margin_m = 0.0;     ///< surface kept beyond the tile where there are no neighbours
  std::vector<std::filesystem::path> fill_dem;  ///< rasters; empty: gaps are left to the field
  FillOptions fill;
  SolveOptions solve;
  ExtractOptions extract;
  SupportOptions support;
};

/// The three actions as stages; `command` must stay where it is.
Stage solve_stage(Command& command);
Stage extract_stage(Command& command);
Stage mesh_stage(Command& command);
/// For a command line without one of them: its help, its version, or what is wrong.
Stage choose_stage(Command& command);

}  // namespace cornice::poisson
