// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/command_extract.h"

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "core/io/mesh_export.h"
#include "hlod/extract.h"
#include "stages/hlod/command.h"

namespace cornice::hlod {
namespace {

struct ExtractCommand {
  std::string action;
  std::filesystem::path file, output;
  std::optional<double> level, error_m;
  std::vector<double> eye;
  double pixels = 1.0;
  double viewport = 1080.0;
  double view_deg = 45.0;
};

std::vector<Option> describe(ExtractCommand& c) {
  return {
      Option("level", c.level, "this level, 0 the coarsest").range(0, 16),
      Option("error-m", c.error_m, "the coarsest level with no error above this")
          .at_least(0)
          .unit("m"),
      Option("eye", c.eye, "E,N,H: what is drawn for an eye there, all around it").unit("m"),
      Option("pixels", c.pixels, "with --eye: no error is drawn larger than this").above(0),
      Option("viewport", c.viewport, "with --eye: height of the picture")
          .range(1, 100000)
          .unit("pixels"),
      Option("view-deg", c.view_deg, "with --eye: angle of that height")
          .range(1, 170)
          .unit("degrees"),
  };
}

void check(const ExtractCommand& c) {
  const int ways = (c.level ? 1 : 0) + (c.error_m ? 1 : 0) + (c.eye.empty() ? 0 : 1);
  if (ways != 1) throw UsageError("--level", "give one of --level, --error-m and --eye");
  if (!c.eye.empty() && c.eye.size() != 3) throw UsageError("--eye", "takes three numbers, E,N,H");
  if (c.level && *c.level != std::floor(*c.level)) {
    throw UsageError("--level", "must be a whole number");
  }
  if (!is_mesh_extension(c.output)) throw UsageError("--output", "must end in .ply, .obj or .glb");
}

Mesh view(const ExtractCommand& c, const File& file, int threads, Progress& progress) {
  const Tree tree = make_tree(file.header(), file.nodes());
  const double scale = error_scale(c.pixels, c.viewport, c.view_deg);
  const FinePoint eye = fine_eye({c.eye[0], c.eye[1], c.eye[2]}, file.header().lattice);
  const Radii radii = radii_for_eye(tree, scale, eye);
  return extract_view(file, tree, radii, eye, threads, progress);
}

void extract(const ExtractCommand& c, StageContext& context) {
  check(c);
  Report& report = context.report;
  const int threads = context.options.threads;
  report.add_input(c.file);
  const File file(c.file);
  const int finest = file.header().lattice.finest_level;
  if (c.level && *c.level > finest) {
    throw UsageError("--level", "the finest level is " + std::to_string(finest));
  }
  Mesh mesh;
  report.step("extract", [&] {
    const int level =
        c.level ? static_cast<int>(*c.level) : level_for_error(file, c.error_m.value_or(0.0));
    mesh = c.eye.empty() ? extract_level(file, level, threads, context.progress)
                         : view(c, file, threads, context.progress);
    if (c.eye.empty()) report.quality("level", level);
  });
  report.count("vertices", mesh.positions.size());
  report.count("triangles", mesh.triangles.size());
  report.step("write", [&] { export_mesh(c.output, mesh); });
}

}  // namespace

int run_extract(int argc, char** argv) {
  ExtractCommand command;
  Stage stage;
  stage.name = "hlod";
  stage.description = "Takes a mesh out of a hierarchy: one level, or what an eye sees";
  stage.options = {action_option(command.action, "extract"),
                   Option("FILE", command.file, "hierarchy, .hlod").positional().required(),
                   output_option(command.output, "mesh, .ply, .obj or .glb")};
  stage.add(describe(command), "What to take");
  stage.examples = {"cornice-hlod extract survey.hlod -o coarse.ply --error-m 2",
                    "cornice-hlod extract survey.hlod -o view.glb --eye 998200,6536300,2600"};
  stage.run = [&](StageContext& context) { extract(command, context); };
  return run_stage(argc, argv, std::move(stage));
}

}  // namespace cornice::hlod
