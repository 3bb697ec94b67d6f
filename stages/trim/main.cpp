// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-trim: a reconstructed mesh in, the part of it that measurements support out.
#include <algorithm>
#include <functional>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "core/io/ply.h"
#include "stages/trim/command.h"
#include "stages/trim/model_surface.h"
#include "stages/trim/point_support.h"

namespace {

using namespace cornice;

/// What the stage needs at its peak: the mesh twice, its edges, the fates of its vertices.
constexpr std::uint64_t kBytesPerTriangle = 120;

/// Vertices on the elevation model that the options name; none without one.
std::vector<std::uint8_t> on_model(const trim::Command& command, const Mesh& mesh,
                                   StageContext& context) {
  if (command.fill_dem.empty()) return {};
  Report& report = context.report;
  std::vector<std::uint8_t> held;
  report.step("elevation model", [&] {
    const auto model = ElevationModel::read(command.fill_dem, mesh.crs_text, trim::plan_box(mesh));
    report.count("rasters used", model.rasters_used());
    if (model.without_vertical() > 0) {
      report.warn(std::to_string(model.without_vertical()) +
                  " rasters do not say what their heights refer to; they are taken to be in the "
                  "mesh's system");
    }
    held = trim::find_model_surface(mesh, model, command.fill_within_m, context.options.threads);
    if (!model.empty() && std::find(held.begin(), held.end(), 1) == held.end()) {
      report.warn(
          "no surface lies on that of the rasters, measured or not; do their heights refer "
          "to something else?");
    }
  });
  return held;
}

/// Runs what does not know its file's name, and puts the name to its errors.
void of_file(const std::filesystem::path& file, const std::function<void()>& body) {
  try {
    body();
  } catch (const InputError& error) {
    throw InputError(file.string(), error.problem());
  }
}

void run(trim::Command& command, StageContext& context) {
  Report& report = context.report;
  command.options.threads = context.options.threads;
  if (command.options.min_support_m > command.options.max_support_m) {
    throw UsageError("--min-support", "must not exceed --max-support");
  }
  report.add_input(command.mesh);
  if (!command.points.empty()) report.add_input(command.points);
  context.memory.charge("the mesh", read_ply_info(command.mesh).count("face") * kBytesPerTriangle);
  Mesh mesh;
  report.step("read", [&] { mesh = read_ply_mesh(command.mesh); });
  const std::vector<std::uint8_t> held = on_model(command, mesh, context);
  if (!command.points.empty()) {
    report.step("support", [&] {
      const OrientedPoints points = read_ply_points(command.points);
      of_file(command.points, [&] { trim::add_support(mesh, points, context.options.threads); });
    });
  }
  trim::Result result;
  report.step("trim", [&] {
    of_file(command.mesh,
            [&] { result = trim::trim(mesh, command.options, held, context.progress); });
  });
  trim::report_counts(result.counts, result.mesh, report);
  report.step("write", [&] { write_ply(command.output, result.mesh); });
}

}  // namespace

int main(int argc, char** argv) {
  trim::Command command;
  Stage stage;
  stage.name = "trim";
  stage.description = "Takes surface without measurements off a reconstructed mesh";
  stage.options = trim::describe(command);
  stage.examples = {"cornice-trim tile.ply -o trimmed.ply --bridge 20",
                    "cornice-trim foreign.ply --points points.ply -o trimmed.ply",
                    "cornice-trim tile.ply -o trimmed.ply --fill-dem dem/*.tif"};
  stage.run = [&](StageContext& context) { run(command, context); };
  return run_stage(argc, argv, std::move(stage));
}
