// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/command_build.h"

#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "stages/hlod/build_jobs.h"
#include "stages/hlod/command.h"

namespace cornice::hlod {
namespace {

std::vector<Option> describe(BuildCommand& c) {
  BuildOptions& o = c.options;
  return {
      Option("partition", o.partition,
             {{"quadtree", Partition::kQuadtree}, {"octree", Partition::kOctree}},
             "quadtree: columns, for DEMs and gentle ground; octree: cubes, for walls and "
             "overhangs"),
      Option("cell-side", o.cell_side_m, "side of the finest cells; otherwise by the data")
          .above(0)
          .unit("m"),
      Option("levels", c.levels, "0: as many as end in one cell").range(0, 17),
      Option("triangles-per-cell", o.triangles_per_cell, "wanted where --cell-side is not given")
          .range(16, 100000),
      Option("normal-bits", o.normal_bits, "8 or 10 a component: off by up to 0.95 or 0.24 degrees")
          .range(8, 10),
      Option("attribute-weight", o.block.attribute_weight,
             "part of a cell's side that black to white, or the whole texture, counts as; 0: "
             "colour and texture steer nothing")
          .range(0, 1),
      Option("out-of-core", c.out_of_core, "cells on disk even where memory would do"),
      Option("region", c.region,
             "I/N: builds the finer levels of the I-th of N parts; the output is for --join"),
      Option("join", c.join, "the inputs are the outputs of all regions"),
      Option("edge-share", o.edge_share, "longest edge, as a part of a cell's side")
          .range(0.01, 0.45)
          .advanced(),
      Option("block-side", o.block.side, "cells along a block, a multiple of 4")
          .range(4, 64)
          .advanced(),
      Option("keep-share", o.block.keep_share, "of the triangles, from level to level")
          .range(0.01, 0.9)
          .advanced(),
      Option("max-error-share", o.block.max_error_share,
             "no collapse moves the surface by more than this part of a cell's side")
          .above(0)
          .advanced(),
      Option("work", c.work, "folder for cells on disk; otherwise beside the output").advanced(),
      Option("max-pieces", o.max_pieces, "that triangles longer than --edge-share may be cut into")
          .advanced(),
  };
}

void check(BuildCommand& command) {
  if (command.levels > 0) command.options.levels = command.levels;
  if (command.join && !command.region.empty()) {
    throw UsageError("--join", "joins regions; it takes no --region");
  }
  if (command.region.empty() && command.output.extension() != ".hlod") {
    throw UsageError("--output", "must end in .hlod, but is " + command.output.string());
  }
  if (command.options.block.side % 4 != 0) {
    throw UsageError("--block-side", "must be a multiple of 4");
  }
  if (command.options.normal_bits == 9) throw UsageError("--normal-bits", "must be 8 or 10");
}

}  // namespace

int run_build(int argc, char** argv) {
  BuildCommand command;
  Stage stage;
  stage.name = "hlod";
  stage.description = "Builds a hierarchy of levels of detail of mesh tiles";
  stage.options = {action_option(command.action, "build"),
                   Option("TILE", command.tiles,
                          "meshes that share their borders, .ply (of any size), .obj, .off, .stl")
                       .positional()
                       .required(),
                   output_option(command.output, "hierarchy, .hlod")};
  stage.add(describe(command), "Hierarchy");
  stage.examples = {"cornice-hlod build stitched/*.ply -o survey.hlod",
                    "cornice-hlod build cliff.ply -o cliff.hlod --partition octree"};
  stage.run = [&](StageContext& context) {
    check(command);
    run_build_job(command, context);
  };
  return run_stage(argc, argv, std::move(stage));
}

}  // namespace cornice::hlod
