// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/command.h"

#include <map>

#include "core/base/error.h"

namespace cornice::stitch {

std::string Command::mesh_extension() const {
  const std::string extension = output.extension().string();
  return extension == ".ply" || extension == ".obj" || extension == ".glb" ? extension : "";
}

std::vector<Option> describe(Command& c) {
  return {
      Option("TILES", c.tiles, "all mesh tiles of a survey, .ply").positional().required(),
      Option("output", c.output,
             "folder for tiles of the same names; or FILE.ply, .obj or .glb for one mesh")
          .short_flag('o')
          .output(),
      Option("format", c.format, "of tiles in a folder").words({"ply", "obj", "glb"}),
      Option("tolerance-m", c.options.tolerance_m,
             "borders that do not meet exactly are joined up to this distance; 0: none")
          .range(0, 10)
          .unit("m"),
      Option("overlaps", c.options.overlaps,
             {{"refuse", Overlaps::kRefuse}, {"cut", Overlaps::kCut}, {"keep", Overlaps::kKeep}},
             "of tiles whose surfaces lie over each other: cut gives each its side of the middle"),
      Option("min-area", c.options.min_area_m2,
             "smaller parts of the whole surface go, over all tiles; 0: none")
          .range(0, 1e9)
          .unit("m2"),
      Option("check", c.check, "only looks: writes nothing, exit code 3 where tiles do not meet"),
  };
}

void check_command(const Command& c) {
  if (c.check != c.output.empty()) {
    throw UsageError("--output", c.check ? "is not for --check, which writes nothing"
                                         : "is missing; or give --check");
  }
  if (c.check && c.options.min_area_m2 > 0.0) {
    throw UsageError("--min-area", "is not for --check, which drops nothing");
  }
  std::map<std::filesystem::path, std::filesystem::path> names;
  for (const std::filesystem::path& tile : c.tiles) {
    const auto [first, is_new] = names.emplace(tile.stem(), tile);
    if (is_new) continue;
    throw UsageError(tile.string(), "has the name of " + first->second.string() +
                                        "; every tile needs a name of its own");
  }
}

void report_survey(const Survey& survey, Report& report) {
  report.count("tiles", survey.paths.size());
  report.count("empty tiles", survey.empty_tiles);
  if (survey.empty_tiles > 0) {
    report.warn(std::to_string(survey.empty_tiles) + " tiles have no triangles");
  }
  if (survey.moved_origins > 0) {
    report.warn(std::to_string(survey.moved_origins) +
                " tiles had an origin between whole metres; it was moved, which rounds positions");
  }
  if (survey.without_crs > 0) {
    report.warn(std::to_string(survey.without_crs) +
                " tiles name no CRS; they are taken to be in " + survey.crs_text);
  }
  report.count("small parts", survey.small_parts);
  report.quality("small_parts_area_m2", survey.small_parts_area_m2);
  if (survey.small_parts > 0 && survey.box.empty()) {
    report.warn("no part of the surface is as large as --min-area; nothing is left");
  }
  for (const std::string& overlap : survey.overlaps) report.warn(overlap);
}

void report_seams(const SeamReport& seams, Report& report) {
  report.count("shared edges", seams.shared_edges);
  const auto fault = [&](const char* figure, const char* words, std::uint64_t count) {
    report.quality(figure, count);
    if (count > 0) report.warn(std::to_string(count) + " " + words);
  };
  fault("open_edges", "edges lie along another tile's border without matching it",
        seams.open_edges);
  fault("t_vertices", "vertices lie inside another tile's border edge", seams.t_vertices);
  fault("mismatched_vertices", "border vertices have no equal on the other side",
        seams.mismatched_vertices);
  fault("non_manifold_edges", "edges have more than two triangles", seams.non_manifold_edges);
  fault("turned_triangles", "triangle pairs face opposite sides across a border",
        seams.turned_triangles);
  fault("degenerate_triangles", "triangles have no area", seams.degenerate_triangles);
}

void report_stitching(const StitchResult& result, Report& report) {
  report.count("vertices", result.vertices);
  report.count("triangles", result.triangles);
  report.count("shared vertices", result.shared_vertices);
  report.count("moved vertices", result.plan.moved_vertices);
  report.count("new vertices", result.plan.new_vertices);
  report.count("collapsed edges", result.plan.collapsed_edges);
  report.count("flipped edges", result.flipped_edges);
  report.quality("largest_move_m", result.plan.largest_move_m);
  report_seams(result.seams, report);
}

}  // namespace cornice::stitch
