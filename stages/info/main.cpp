// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-info: what is in a file, on stdout.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "stages/info/examine.h"
#include "stages/info/show.h"

namespace {

using namespace cornice;

struct Command {
  std::vector<std::filesystem::path> files;
  std::string crs;
  bool json = false;
  bool full = false;
};

std::vector<Option> describe(Command& command) {
  return {
      Option("FILE", command.files, "LAS, LAZ, COPC, PLY, or a raster that GDAL reads")
          .positional()
          .required(),
      Option("json", command.json, "JSON for machines instead of text"),
      Option("full", command.full, "a screen for every file, where there are several"),
      Option("crs", command.crs, "coordinate system in place of the files' own, EPSG:2056+5728")};
}

info::Outcome look(const std::filesystem::path& path, const info::ExamineOptions& options,
                   StageContext& context) {
  info::Outcome outcome;
  outcome.path = path;
  try {
    outcome.facts = info::examine(path, options, context.progress);
    context.report.add_input(path);
    context.report.count("defects", outcome.facts->defects.size());
  } catch (const InputError& error) {
    outcome.error = error.what();
    context.report.count("unreadable files", 1);
  }
  return outcome;
}

void print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    throw RunError("standard output", "cannot be written");
  }
}

void run(const Command& command, StageContext& context) {
  const bool one_line_each = command.files.size() > 1 && !command.full;
  const info::ExamineOptions options{context.options.threads, command.crs};
  std::vector<info::Outcome> outcomes;
  std::size_t failed = 0;
  for (const auto& path : command.files) {
    info::Outcome outcome = look(path, options, context);
    failed += outcome.facts ? 0 : 1;
    if (command.json) {
      outcomes.push_back(std::move(outcome));
    } else if (!outcome.facts) {
      if (command.files.size() > 1) print("error: " + outcome.error + "\n");
      if (outcomes.empty()) outcomes.push_back(std::move(outcome));  // the first is the one named
    } else {
      print(one_line_each ? info::summary_line(*outcome.facts) + "\n"
                          : info::screen_text(*outcome.facts) + (command.full ? "\n" : ""));
    }
  }
  if (command.json) print(info::json_text(outcomes));
  if (failed == 0) return;
  for (const info::Outcome& outcome : outcomes) {
    if (outcome.facts) continue;
    const std::string name = outcome.path.string() + ": ";
    const std::string problem =
        outcome.error.starts_with(name) ? outcome.error.substr(name.size()) : outcome.error;
    const std::string others = command.files.size() == 1
                                   ? ""
                                   : " (" + std::to_string(failed) + " of " +
                                         std::to_string(command.files.size()) +
                                         " files cannot be read)";
    throw InputError(outcome.path.string(), problem + others);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Command command;
  Stage stage;
  stage.name = "info";
  stage.description =
      "Says what is in point clouds, meshes and rasters, and what is wrong with them";
  stage.options = describe(command);
  stage.examples = {"cornice-info tile.copc.laz", "cornice-info --json tiles/*.laz"};
  stage.run = [&](StageContext& context) { run(command, context); };
  return run_stage(argc, argv, std::move(stage));
}
