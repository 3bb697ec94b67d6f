// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/command.h"

#include <cstdio>

#include "core/cli/stage.h"

namespace cornice::remesh {
namespace {

nlohmann::json quality_json(const QualityReport& q) {
  return {{"triangles", q.triangles},
          {"below_20_deg", q.below_20_deg},
          {"share_min_angle_20", q.share_min_angle_20()},
          {"smallest_angle_deg", q.smallest_angle_deg},
          {"mean_smallest_angle_deg", q.mean_smallest_angle_deg},
          {"mean_radius_ratio", q.mean_radius_ratio},
          {"smallest_radius_ratio", q.smallest_radius_ratio},
          {"without_area", q.without_area},
          {"shortest_edge_m", q.shortest_edge_m},
          {"longest_edge_m", q.longest_edge_m}};
}

/// Of the triangles below 20 degrees, those that touch a vertex that may not move.
nlohmann::json thin_at_fixed(const Figures& f) {
  const std::uint64_t all = f.quality.below_20_deg, inner = f.inner_quality.below_20_deg;
  return {{"triangles", all - inner},
          {"share_of_thin",
           all == 0 ? 0.0 : static_cast<double>(all - inner) / static_cast<double>(all)}};
}

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f m", value);
  return text;
}

}  // namespace

std::vector<Option> describe(Command& c) {
  Options& o = c.options;
  return {
      Option("MESH", c.mesh, "mesh to remesh, .ply").positional().required(),
      output_option(c.output, "remeshed mesh, .ply").ending(".ply"),
      Option("max-error", o.max_error_m, "largest distance between input and result, both ways")
          .range(0.0001, 1000)
          .unit("m"),
      Option("min-edge", o.min_edge_m, "shortest edge to ask for; the error bound goes first")
          .range(0, 1000)
          .unit("m"),
      Option("max-edge", o.max_edge_m, "longest edge to ask for").range(0.001, 10000).unit("m"),
      Option("grading", o.grading, "growth of edges per metre away from short ones").range(0.05, 2),
      Option("passes", o.passes, "of splitting, collapsing, flipping and smoothing")
          .range(1, 50)
          .advanced(),
  };
}

void report_figures(const Result& result, const Options& options, Report& report) {
  const Figures& f = result.figures;
  report.count("vertices", result.mesh.positions.size());
  report.count("triangles", result.mesh.triangles.size());
  report.count("input triangles", f.input_triangles);
  report.count("triangles after decimation", f.decimated_triangles);
  report.count("dropped triangles", f.dropped_triangles);
  report.count("fixed vertices", f.fixed_vertices);
  report.count("repair rounds", static_cast<std::uint64_t>(f.repair_rounds));
  report.quality("hausdorff_m", f.hausdorff_m());
  report.quality("input_to_result_m", f.input_to_result_m);
  report.quality("result_to_input_m", f.result_to_input_m);
  report.quality("sample_spacing_m", f.sample_spacing_m);
  report.quality("all triangles", quality_json(f.quality));
  report.quality("thin_at_fixed_vertices", thin_at_fixed(f));
  report.quality("triangles away from fixed vertices", quality_json(f.inner_quality));
  if (f.bad_input_edges > 0) {
    report.warn("the input is no manifold along " + std::to_string(f.bad_input_edges) +
                " sides of triangles; their vertices are kept as they are");
  }
  if (f.dropped_triangles > 0) {
    report.warn(std::to_string(f.dropped_triangles) +
                " triangles of the input name a vertex twice or repeat another; they are dropped");
  }
  if (f.hausdorff_m() > options.max_error_m) {
    report.warn("the result is up to " + metres(f.hausdorff_m()) +
                " away from the input, more than --max-error " + metres(options.max_error_m));
  }
}

}  // namespace cornice::remesh
