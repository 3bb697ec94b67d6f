// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/hlod/command_build.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "core/cli/version.h"
#include "core/io/ply.h"
#include "hlod/build.h"
#include "hlod/file.h"
#include "stages/hlod/command.h"

namespace cornice::hlod {
namespace {

namespace fs = std::filesystem;

struct BuildCommand {
  std::string action;
  std::vector<fs::path> tiles;
  fs::path output;
  BuildOptions options;
  std::optional<double> levels;
};

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
      Option("levels", c.levels, "otherwise as many as end in one cell").range(1, 17),
      Option("triangles-per-cell", o.triangles_per_cell, "wanted where --cell-side is not given")
          .range(16, 100000),
      Option("normal-bits", o.normal_bits, "8 or 10 a component: off by up to 0.95 or 0.24 degrees")
          .range(8, 10),
      Option("attribute-weight", o.block.attribute_weight,
             "part of a cell's side that black to white, or the whole texture, counts as; 0: "
             "colour and texture steer nothing")
          .range(0, 1),
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
      Option("max-pieces", o.max_pieces, "that triangles longer than --edge-share may be cut into")
          .advanced(),
  };
}

void check(const BuildCommand& command) {
  if (command.options.block.side % 4 != 0) {
    throw UsageError("--block-side", "must be a multiple of 4");
  }
  if (command.options.normal_bits == 9) throw UsageError("--normal-bits", "must be 8 or 10");
}

std::string provenance_of(const BuildCommand& command, const Header& header) {
  nlohmann::ordered_json json;
  json["program"] = "cornice-hlod build";
  json["version"] = version_text();
  json["cell_side_m"] = header.lattice.cell_side(header.lattice.finest_level);
  json["block_side"] = command.options.block.side;
  json["keep_share"] = command.options.block.keep_share;
  json["attribute_weight"] = command.options.block.attribute_weight;
  json["max_error_share"] = command.options.block.max_error_share;
  for (const fs::path& tile : command.tiles) json["inputs"].push_back(tile.filename().string());
  return json.dump();
}

void report_counts(const LeafCounts& leaves, const std::vector<LevelCounts>& levels,
                   Report& report) {
  report.count("triangles_in", leaves.triangles);
  report.count("degenerate_left_out", leaves.degenerate);
  report.count("duplicates_left_out", leaves.duplicate);
  report.count("pieces_of_long_triangles", leaves.split_pieces);
  std::uint64_t all = 0, cells = 0;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const LevelCounts& l = levels[level];
    all += l.triangles;
    cells += l.cells;
    rows.push_back({{"level", level},
                    {"cells", l.cells},
                    {"triangles", l.triangles},
                    {"blocks", l.blocks},
                    {"locked_vertices", l.locked_vertices},
                    {"error_max_m", l.error_max_m}});
  }
  report.count("triangles_all_levels", all);
  report.count("cells", cells);
  report.quality("levels", rows);
}

void build(BuildCommand& command, StageContext& context) {
  check(command);
  Report& report = context.report;
  const int threads = context.options.threads;
  if (command.levels) command.options.levels = static_cast<int>(*command.levels);
  std::vector<Mesh> meshes;
  InputSummary input;
  report.step("read", [&] {
    for (const fs::path& tile : command.tiles) {
      check_cancelled(context.progress);
      report.add_input(tile);
      meshes.push_back(read_ply_mesh(tile));
      summarise(meshes.back(), tile.string(), threads, input);
    }
  });
  Header header = plan_header(input, command.options);
  header.provenance = provenance_of(command, header);
  LeafMaker maker(header, command.options.max_pieces, threads);
  LeafCounts counts;
  std::vector<BuildCell> leaves;
  report.step("leaves", [&] {
    std::vector<std::vector<BuildCell>> pieces;
    for (Mesh& mesh : meshes) {
      check_cancelled(context.progress);
      pieces.push_back(maker.pieces(mesh));
      mesh = {};
    }
    counts = maker.counts();
    leaves = finish_leaves(std::move(pieces), header, threads, counts);
  });
  FileWriter writer(command.output, header);
  std::vector<LevelCounts> levels;
  report.step("levels", [&] {
    levels = build_levels(
        std::move(leaves), header, command.options.block, threads,
        [&](FinishedPart part) { writer.add(part.node, encode_cell(part.mesh, header)); },
        context.progress);
  });
  report.step("finish", [&] { writer.finish(); });
  report_counts(counts, levels, report);
}

}  // namespace

int run_build(int argc, char** argv) {
  BuildCommand command;
  Stage stage;
  stage.name = "hlod";
  stage.description = "Builds a hierarchy of levels of detail of mesh tiles";
  stage.options = {action_option(command.action, "build"),
                   Option("TILE", command.tiles, "meshes that share their borders, .ply")
                       .positional()
                       .required(),
                   output_option(command.output, "hierarchy, .hlod")};
  stage.add(describe(command), "Hierarchy");
  stage.examples = {"cornice-hlod build stitched/*.ply -o survey.hlod",
                    "cornice-hlod build cliff.ply -o cliff.hlod --partition octree"};
  stage.run = [&](StageContext& context) { build(command, context); };
  return run_stage(argc, argv, std::move(stage));
}

}  // namespace cornice::hlod
