// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-compare: two surfaces of one place in, how they differ out.
#include <memory>

#include "core/base/memory.h"
#include "core/cli/stage.h"
#include "stages/compare/command.h"
#include "stages/compare/output.h"

namespace {

using namespace cornice;

/// Share of the memory for files that are kept between parts; the rest is for the part in work,
/// its surroundings, their trees and the grid.
constexpr std::uint64_t kCacheShare = 3;

void run(compare::Command& command, StageContext& context) {
  Report& report = context.report;
  compare::Options& options = command.options;
  options.threads = context.options.threads;
  const std::vector<compare::ProfileLine> lines = compare::profile_lines(command.profiles);
  const std::uint64_t limit =
      context.memory.limit_bytes() > 0 ? context.memory.limit_bytes() : available_memory_bytes();
  // Both sides keep files.
  const std::uint64_t cache = limit / kCacheShare / 2;
  std::unique_ptr<compare::Source> a, b;
  report.step("open", [&] {
    for (const auto& path : {command.a, command.b}) {
      for (const auto& file : compare::files_of(path)) report.add_input(file);
    }
    a = compare::open_source(command.a, options, cache);
    b = compare::open_source(command.b, options, cache);
  });
  compare::Output output({command.output, command.meshes, command.heading_deg});
  std::optional<compare::Result> result;
  report.step("compare", [&] {
    result = compare::compare(
        *a, *b, options, lines, [&](const compare::MeasuredPart& part) { output.add(part); },
        context.progress);
  });
  report.step("versions", [&] {
    for (const auto& path : command.versions) {
      for (const auto& file : compare::files_of(path)) report.add_input(file);
      const auto version = compare::open_source(path, options, cache);
      result->versions.push_back(
          compare::measure_version(*version, *b, *result, options, context.progress));
    }
  });
  report.step("write", [&] {
    for (const std::string& problem : output.finish(*result, options)) report.warn(problem);
  });
  for (const auto& file : output.files()) report.add_output(file);
  compare::report_result(*result, report);
}

}  // namespace

int main(int argc, char** argv) {
  compare::Command command;
  Stage stage;
  stage.name = "compare";
  stage.description = "Measures how two surfaces of one place differ, and what a DEM cannot hold";
  stage.options = compare::describe(command);
  stage.examples = {"cornice-compare dem.tif mesh.ply -o differences",
                    "cornice-compare swissalti3d/ tiles/ -o differences --classes 2 "
                    "--profile 2600100,1200400,2600300,1200400"};
  stage.run = [&](StageContext& context) { run(command, context); };
  return run_stage(argc, argv, std::move(stage));
}
