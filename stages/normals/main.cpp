// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-normals: a tile, its neighbours and its flight lines in, oriented points out.
#include <cstdint>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/cli/log.h"
#include "core/cli/stage.h"
#include "core/io/flight_lines_file.h"
#include "stages/normals/command.h"

namespace {

using namespace cornice;

/// What the stage needs at its peak, per point.
constexpr std::uint64_t kBytesPerPoint = 100;

void run(normals::Command& command, StageContext& context) {
  Report& report = context.report;
  const int threads = context.options.threads;
  normals::Options& options = command.options;
  options.threads = threads;
  options.neighbours = normals::neighbour_rule(command);
  options.keep_source = !command.las.empty();
  std::string rules_name;
  const normals::ClassRules rules = normals::class_rules(command, rules_name);
  report.quality("class rules", rules_name);
  report.add_input(command.input.tile);
  for (const auto& path : command.input.neighbours) report.add_input(path);
  report.add_input(command.flight_lines);

  const FlightLines lines = read_flight_lines(command.flight_lines);
  context.memory.charge("points of the tile and its halo",
                        normals::promised_points(command.input) * kBytesPerPoint);
  normals::TilePoints tile;
  report.step("read", [&] { tile = normals::read_tile(command.input, threads, context.progress); });
  for (const std::string& warning : tile.warnings) report.warn(warning);
  normals::Result result;
  report.step("normals", [&] {
    result = normals::compute_normals(std::move(tile.points), tile.tile_points, lines, rules,
                                      options, context.progress);
  });
  normals::report_counts(result.counts, rules_name, report);
  if (!command.las.empty()) {
    report.step("write LAS", [&] {
      normals::write_oriented_las(command.las, tile.info, result, threads, context.progress);
    });
  }
  report.step("write PLY", [&] {
    normals::write_oriented_ply(command.output, std::move(result), tile.info.crs.text());
  });
}

}  // namespace

int main(int argc, char** argv) {
  normals::Command command;
  Stage stage;
  stage.name = "normals";
  stage.description = "Estimates the normals of a tile's points and turns them out of the ground";
  stage.options = normals::describe(command);
  stage.examples = {
      "cornice-normals tile.laz --flightlines lines.gpkg -o points.ply",
      "cornice-normals b.laz --neighbours a.laz c.laz --flightlines lines.json -o b.ply"};
  stage.run = [&](StageContext& context) { run(command, context); };
  return run_stage(argc, argv, std::move(stage));
}
