// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cornice-trim.
#pragma once

#include <filesystem>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/report.h"
#include "stages/trim/trim.h"

namespace cornice::trim {

/// Everything the command line says.
struct Command {
  std::filesystem::path mesh;
  std::filesystem::path points;  ///< empty: the mesh says its support itself
  std::filesystem::path output;
  std::vector<std::filesystem::path> fill_dem;  ///< rasters of heights
  double fill_within_m = 1.0;                   ///< of the elevation model's surface
  Options options;
};

/// Options of `command`, which must stay where it is.
std::vector<Option> describe(Command& command);

void report_counts(const Counts& counts, const Mesh& mesh, Report& report);

}  // namespace cornice::trim
