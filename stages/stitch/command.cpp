// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/command.h"

#include "core/cli/stage.h"

namespace cornice::stitch {

std::vector<Option> describe(Command& c) {
  Options& o = c.options;
  return {
      Option("TILES", c.tiles, "meshes of neighbouring tiles, .ply").positional().required(),
      output_option(c.output, "folder for conforming tiles; or one mesh, .ply, .obj or .glb"),
      Option("format", c.format, "of the tiles in the folder").words({"ply", "obj", "glb"}),
      Option("reach", o.reach_m, "border vertices farther apart than this are no neighbours")
          .range(0, 100)
          .unit("m"),
      Option("collapse", o.collapse_m,
             "a vertex between two matched ones moves onto one as near as this; farther ones are "
             "put into the other tile's edge")
          .range(0, 100)
          .unit("m"),
  };
}

void report_plan(const Plan& plan, Report& report) {
  report.count("border vertices that matched", plan.exact_vertices);
  report.count("corners", plan.corners);
  report.count("projected", plan.projected);
  report.count("collapsed", plan.collapsed);
  report.count("inserted", plan.inserted);
}

void report_seams(const SeamReport& before, const SeamReport& after, Report& report) {
  report.count("shared vertices", after.shared_vertices);
  report.quality("open_edges_before", before.open_edges);
  report.quality("mismatched_vertices_before", before.mismatched_vertices);
  report.quality("shared_edges", after.shared_edges);
  report.quality("open_edges", after.open_edges);
  report.quality("t_vertices", after.t_vertices);
  report.quality("mismatched_vertices", after.mismatched_vertices);
  report.quality("non_manifold_edges", after.non_manifold_edges);
  report.quality("flipped_neighbours", after.flipped_neighbours);
  const auto warn = [&](std::uint64_t count, const char* what) {
    if (count > 0) report.warn(std::to_string(count) + " " + what);
  };
  warn(after.open_edges, "edges of tiles are open between vertices that a neighbour shares");
  warn(after.t_vertices, "vertices lie inside an edge of a neighbour");
  warn(after.mismatched_vertices, "border vertices nearly meet one of a neighbour; try --reach");
  warn(after.non_manifold_edges, "edges belong to more than two triangles");
  warn(after.flipped_neighbours, "triangles are turned against their neighbour across a border");
}

}  // namespace cornice::stitch
