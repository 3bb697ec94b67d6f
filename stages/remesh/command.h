// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cornice-remesh.
#pragma once

#include <filesystem>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/report.h"
#include "stages/remesh/remesh.h"

namespace cornice::remesh {

/// Everything the command line says.
struct Command {
  std::filesystem::path mesh;
  std::filesystem::path output;
  Options options;
};

/// Options of `command`, which must stay where it is.
std::vector<Option> describe(Command& command);

void report_figures(const Result& result, const Options& options, Report& report);

}  // namespace cornice::remesh
