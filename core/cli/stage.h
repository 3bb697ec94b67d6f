// SPDX-License-Identifier: GPL-3.0-or-later
// The frame of every executable: common options, log, progress, report, exit code.
//
//   int main(int argc, char** argv) {
//     normals::Options options;
//     std::filesystem::path tile, output;
//     cornice::Stage stage;
//     stage.name = "normals";
//     stage.description = "Estimates and orients the normals of a tile's points";
//     stage.options = {cornice::Option("TILE", tile, "LAS, LAZ or COPC
//     file").positional().required(),
//                      cornice::output_option(output, "oriented points, .ply")};
//     stage.add(normals::describe(options), "Normals");
//     stage.examples = {"cornice-normals tile.laz -o points.ply"};
//     stage.run = [&](cornice::StageContext& context) { ... };
//     return cornice::run_stage(argc, argv, std::move(stage));
//   }
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/memory.h"
#include "core/base/progress.h"
#include "core/cli/options.h"
#include "core/cli/report.h"

namespace cornice {

/// Options every stage has (the contract of a stage, ARCHITECTURE.md).
struct CommonOptions {
  int threads = 0;          ///< 0: all cores
  double memory_gib = 0.0;  ///< 0: the machine's
  std::string log_level = "info";
  bool no_progress = false;
  bool overwrite = false;
  std::filesystem::path report;  ///< empty: none
};

/// What a stage's own code gets.
struct StageContext {
  const CommonOptions& options;
  Report& report;
  Progress& progress;
  MemoryBudget& memory;
};

/// One executable: what it is called, takes and does.
struct Stage {
  std::string name;         ///< "normals": the executable is cornice-normals
  std::string description;  ///< one sentence without full stop
  std::vector<Option> options;
  std::vector<std::string> examples;  ///< whole command lines, two of them
  std::function<void(StageContext& context)> run;

  /// Appends options under a heading of the help text.
  void add(std::vector<Option> more, const std::string& group);
};

/// The option -o/--output, required. run_stage checks it before the stage runs (check_output),
/// clears what a killed run left of it, and lists it in the report.
Option output_option(std::filesystem::path& output, const std::string& help);

/// Runs one executable: parses argv with the stage's options on top of the common ones, sets up log
/// and progress, calls `run`, writes the report, and turns exceptions into one line on stderr
/// ("cornice-NAME: error: ...") and the exit code of their kind. SIGINT and SIGTERM cancel through
/// Progress::cancelled() and exit 128+n with no half-written file; a stage that does not look at it
/// for kSignalGraceSeconds is ended, its temporary files removed. Returns the exit code.
int run_stage(int argc, char** argv, Stage stage);

/// Slurm sends SIGKILL 30 s after SIGTERM; the end must come before that.
inline constexpr int kSignalGraceSeconds = 15;

/// Throws UsageError where `output` exists (a folder: with something in it) and overwriting was not
/// asked for.
void check_output(const std::filesystem::path& output, const CommonOptions& options);

}  // namespace cornice
