// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-stitch: the tiles of a survey in, tiles that share their borders (or one mesh) out.
#include <set>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "core/io/mesh_export.h"
#include "core/io/ply.h"
#include "stages/stitch/apply.h"
#include "stages/stitch/command.h"
#include "stages/stitch/merge.h"

namespace {

using namespace cornice;

bool is_folder(const stitch::Command& command) { return !command.output.has_extension(); }

/// Every tile's border; tiles of different systems are refused.
std::vector<stitch::TileBorder> read_borders(const stitch::Command& command,
                                             StageContext& context) {
  std::vector<stitch::TileBorder> borders;
  std::string crs;
  std::set<std::string> names;
  context.progress.begin("read borders", command.tiles.size());
  for (const auto& path : command.tiles) {
    check_cancelled(context.progress);
    if (!names.insert(path.stem().string()).second && is_folder(command)) {
      throw UsageError("TILES", "two tiles are called " + path.stem().string() +
                                    "; the output folder holds one of each name");
    }
    const Mesh mesh = read_ply_mesh(path);
    if (!mesh.crs_text.empty()) {
      if (!crs.empty() && crs != mesh.crs_text) {
        throw InputError(path.string(), "is in " + mesh.crs_text + ", tiles before it in " + crs +
                                            "; stitch tiles of one coordinate system");
      }
      crs = mesh.crs_text;
    }
    borders.push_back(stitch::find_border(mesh, context.options.threads));
    context.progress.advance(1);
  }
  context.progress.end();
  return borders;
}

/// Changes and writes tile by tile; returns the finished borders.
std::vector<stitch::TileBorder> write_tiles(const stitch::Command& command,
                                            const stitch::Plan& plan, StageContext& context) {
  Report& report = context.report;
  std::vector<stitch::TileBorder> borders;
  stitch::Merger merger;
  context.progress.begin("write", command.tiles.size());
  for (std::size_t t = 0; t < command.tiles.size(); ++t) {
    check_cancelled(context.progress);
    Mesh mesh = read_ply_mesh(command.tiles[t]);
    const stitch::ApplyCounts counts =
        stitch::apply_plan(mesh, plan.tiles[t], context.options.threads);
    report.count("dropped triangles", counts.dropped_triangles);
    report.count("turned edges", counts.turned_edges);
    report.count("triangles", mesh.triangles.size());
    borders.push_back(stitch::find_border(mesh, context.options.threads));
    if (is_folder(command)) {
      const auto path =
          command.output / (command.tiles[t].stem().string() + "." + command.format);
      export_mesh(path, mesh);
      report.add_output(path);
    } else {
      try {
        merger.add(mesh, context.options.threads);
      } catch (const InputError& error) {
        throw InputError(command.tiles[t].string(), error.problem());
      }
    }
    context.progress.advance(1);
  }
  context.progress.end();
  if (!is_folder(command)) export_mesh(command.output, merger.take());
  return borders;
}

void run(stitch::Command& command, StageContext& context) {
  Report& report = context.report;
  command.options.threads = context.options.threads;
  if (!is_folder(command) && !is_mesh_extension(command.output)) {
    throw UsageError("--output", "'" + command.output.string() +
                                     "' is neither a folder nor .ply, .obj or .glb");
  }
  for (const auto& path : command.tiles) report.add_input(path);
  std::vector<stitch::TileBorder> borders;
  report.step("read borders", [&] { borders = read_borders(command, context); });
  stitch::Plan plan;
  report.step("match", [&] { plan = stitch::resolve(borders, command.options); });
  stitch::report_plan(plan, report);
  const stitch::SeamReport before = stitch::check_seams(borders);
  borders.clear();
  report.step("write", [&] { borders = write_tiles(command, plan, context); });
  stitch::report_seams(before, stitch::check_seams(borders), report);
}

}  // namespace

int main(int argc, char** argv) {
  stitch::Command command;
  Stage stage;
  stage.name = "stitch";
  stage.description = "Makes neighbouring tiles share their border vertices bit for bit";
  stage.options = stitch::describe(command);
  stage.examples = {"cornice-stitch tiles/*.ply -o stitched",
                    "cornice-stitch a.ply b.ply -o survey.glb"};
  stage.run = [&](StageContext& context) { run(command, context); };
  return run_stage(argc, argv, std::move(stage));
}
