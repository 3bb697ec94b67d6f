// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cornice-stitch.
#pragma once

#include <filesystem>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/report.h"
#include "stages/stitch/resolve.h"

namespace cornice::stitch {

/// Everything the command line says.
struct Command {
  std::vector<std::filesystem::path> tiles;
  std::filesystem::path output;
  std::string format = "ply";  ///< of the files in an output folder
  Options options;
};

/// Options of `command`, which must stay where it is.
std::vector<Option> describe(Command& command);

void report_plan(const Plan& plan, Report& report);
void report_seams(const SeamReport& before, const SeamReport& after, Report& report);

}  // namespace cornice::stitch
