// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/trim/command.h"

#include "core/cli/stage.h"

namespace cornice::trim {

std::vector<Option> describe(Command& c) {
  Options& o = c.options;
  return {
      Option("MESH", c.mesh, "mesh with the vertex property \"support\", .ply")
          .positional()
          .required(),
      output_option(c.output, "trimmed mesh, .ply").ending(".ply"),
      Option("points", c.points, "measured points, .ply: support and density are taken from them"),
      Option("bridge", o.bridge_m, "gaps up to this width are kept and marked; 0: none")
          .range(0, 1000)
          .unit("m"),
      Option("fill-dem", c.fill_dem,
             "rasters of heights: surface without measurements that follows them is kept and "
             "marked; give cornice-poisson the same"),
      Option("fill-within", c.fill_within_m, "surface so near to the rasters' follows them")
          .range(0, 100)
          .unit("m"),
      Option("min-area", o.min_area_m2, "smaller parts go, unless they reach the tile's edge")
          .range(0, 1e9)
          .unit("m2"),
      Option("spacings", o.spacings, "measured: a point within so many mean distances of points")
          .range(0.5, 100),
      Option("min-support", o.min_support_m, "a point as near as this is always near enough")
          .range(0, 100)
          .unit("m"),
      Option("max-support", o.max_support_m, "a point farther than this never is")
          .range(0.01, 1000)
          .unit("m"),
  };
}

void report_counts(const Counts& counts, const Mesh& mesh, Report& report) {
  report.count("vertices", mesh.positions.size());
  report.count("triangles", mesh.triangles.size());
  report.count("measured vertices", counts.measured_vertices);
  report.count("bridged vertices", counts.bridged_vertices);
  report.count("elevation model vertices", counts.model_vertices);
  report.count("dropped triangles", counts.dropped_triangles);
  report.count("small parts dropped", counts.small_parts);
  report.count("split vertices", counts.split_vertices);
  report.quality("area_m2", counts.area_m2);
  report.quality("bridged_area_m2", counts.bridged_area_m2);
  report.quality("model_area_m2", counts.model_area_m2);
  report.quality("dropped_area_m2", counts.dropped_area_m2);
  if (mesh.triangles.empty()) report.warn("nothing of the mesh is supported; the result is empty");
}

}  // namespace cornice::trim
