// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cornice-compare.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/report.h"
#include "stages/compare/compare.h"

namespace cornice::compare {

/// Everything the command line says.
struct Command {
  std::filesystem::path a, b, output;
  Options options;
  std::vector<std::string> profiles;  ///< "E1,N1,E2,N2", numbers one by one
  std::vector<std::filesystem::path> versions;
  bool meshes = true;
  double heading_deg = -1.0;
};

/// Options of `command`, which must stay where it is.
std::vector<Option> describe(Command& command);

/// The lines of --profile. Throws UsageError for anything but numbers by fours.
std::vector<ProfileLine> profile_lines(const std::vector<std::string>& numbers);

void report_result(const Result& result, Report& report);

}  // namespace cornice::compare
