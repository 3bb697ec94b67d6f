// SPDX-License-Identifier: GPL-3.0-or-later
// The options of cornice-stitch, and what it tells of its work.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/cli/options.h"
#include "core/cli/report.h"
#include "stages/stitch/survey.h"

namespace cornice::stitch {

/// Everything the command line says.
struct Command {
  std::vector<std::filesystem::path> tiles;
  std::filesystem::path output;  ///< a folder; a file where it ends in .ply, .obj or .glb
  std::string format = "ply";    ///< of the tiles in a folder
  bool check = false;
  Options options;

  /// Extension of one mesh to write; empty where tiles are to be written.
  std::string mesh_extension() const;
};

/// Options of `command`, which must stay where it is.
std::vector<Option> describe(Command& command);

/// Throws UsageError for tiles that have one name, or an output that is missing or superfluous.
void check_command(const Command& command);

void report_survey(const Survey& survey, Report& report);
/// A figure for each fault, a warning for each that is not 0.
void report_seams(const SeamReport& seams, Report& report);
void report_stitching(const StitchResult& result, Report& report);

}  // namespace cornice::stitch
