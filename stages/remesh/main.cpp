// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-remesh: a dense mesh in, few well-shaped triangles within a distance of it out.
#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "core/io/ply.h"
#include "stages/remesh/command.h"

namespace {

using namespace cornice;

/// What the stage needs at its peak, per triangle of the input.
constexpr std::uint64_t kBytesPerTriangle = 150;
/// Metres from its origin that a tile may reach: what is further is no tile, and floats hold it to
/// metres only.
constexpr float kFarthestM = 1e7f;

/// Throws where a vertex is not on any tile.
void require_tile(const std::filesystem::path& file, const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3f p = mesh.positions[i];
    if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kFarthestM) {
      throw InputError(file.string(), "has vertex " + std::to_string(i) +
                                          " further than 10,000 km from its origin; leave it out");
    }
  }
}

void run(remesh::Command& command, StageContext& context) {
  Report& report = context.report;
  command.options.threads = context.options.threads;
  if (command.options.min_edge_m > command.options.max_edge_m) {
    throw UsageError("--min-edge", "must not exceed --max-edge");
  }
  report.add_input(command.mesh);
  context.memory.charge("the mesh", read_ply_info(command.mesh).count("face") * kBytesPerTriangle);
  Mesh mesh;
  report.step("read", [&] { mesh = read_ply_mesh(command.mesh); });
  // A tile without ground has neither.
  if (mesh.triangles.empty() && !mesh.positions.empty())
    throw InputError(command.mesh.string(),
                     "holds points but no triangles; make a mesh of them with cornice-poisson");
  require_tile(command.mesh, mesh);
  remesh::Result result;
  report.step("remesh", [&] { result = remesh::remesh(mesh, command.options, context.progress); });
  mesh = {};
  remesh::report_figures(result, command.options, report);
  report.step("write", [&] { write_ply(command.output, result.mesh); });
}

}  // namespace

int main(int argc, char** argv) {
  remesh::Command command;
  Stage stage;
  stage.name = "remesh";
  stage.description = "Turns a dense mesh into few, well-shaped triangles that stay close to it";
  stage.options = remesh::describe(command);
  stage.examples = {"cornice-remesh trimmed.ply -o tile.ply",
                    "cornice-remesh trimmed.ply -o tile.ply --max-error 0.1 --max-edge 10"};
  stage.run = [&](StageContext& context) { run(command, context); };
  return run_stage(argc, argv, std::move(stage));
}
