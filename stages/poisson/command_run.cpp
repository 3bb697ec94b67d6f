// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/command_run.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/input_file.h"
#include "core/io/ply.h"
#include "stages/poisson/band_file.h"

namespace cornice::poisson {
namespace {

/// What the steps need at their peak; measured.
constexpr std::uint64_t kBytesPerPointSolved = 430;
constexpr std::uint64_t kBytesPerPointSupport = 60;
/// Room above the highest and below the lowest point for what the surface does between them.
constexpr double kHeightMarginM = 16.0;
constexpr double kHeightMarginSteps = 16.0;
/// Vertices nearer to a point than this count as measured in the report.
constexpr float kMeasuredM = 1.0f;

OrientedPoints read_points(const std::filesystem::path& path, StageContext& context) {
  OrientedPoints points;
  context.report.add_input(path);
  context.report.step("read", [&] { points = read_ply_points(path); });
  return points;
}

/// The tile's square: as asked for, or the box of the points that are not marked as halo.
Box2d tile_of(const Command& command, const OrientedPoints& points) {
  if (!command.tile.empty()) {
    if (command.tile.size() != 4) {
      throw UsageError("--tile", "has " + std::to_string(command.tile.size()) +
                                     " numbers; give west,south,east,north");
    }
    const Box2d box{command.tile[0], command.tile[1], command.tile[2], command.tile[3]};
    if (!(box.min_x < box.max_x && box.min_y < box.max_y)) {
      throw UsageError("--tile", "is empty; give west,south,east,north");
    }
    return box;
  }
  const std::vector<std::uint8_t>* halo = nullptr;
  for (const ByteProperty& property : points.byte_properties) {
    if (property.name == "halo") halo = &property.values;
  }
  Box2d box;
  for (std::size_t p = 0; p < points.positions.size(); ++p) {
    if (halo != nullptr && (*halo)[p] != 0) continue;
    const Vec3d at = points.origin + points.positions[p].cast<double>();
    if (std::isfinite(at.x) && std::isfinite(at.y)) box.add(at.x, at.y);
  }
  if (box.empty()) {
    throw InputError(command.points.string(), "holds no points that could tell where the tile is");
  }
  // Outwards to whole steps, so that a point on the edge is inside.
  const double step = command.solve.lattice.step_m;
  for (const double metres : {box.min_x, box.min_y, box.max_x, box.max_y}) {
    if (std::abs(metres) < (kFarthestTileNode - 1) * step) continue;
    throw InputError(command.points.string(),
                     "has a point " + std::to_string(metres) +
                         " m from 0, more than 2^27 lattice steps, so its coordinates are "
                         "damaged; make it again, or give the tile with --tile");
  }
  return {std::floor(box.min_x / step) * step, std::floor(box.min_y / step) * step,
          std::floor(box.max_x / step + 1) * step, std::floor(box.max_y / step + 1) * step};
}

/// Part of space in which points count: the tile and its halo, and the heights of the points there.
Box3d domain_of(const Command& command, const Box2d& tile, const OrientedPoints& points) {
  if (points.positions.empty()) {
    throw InputError(command.points.string(),
                     "holds no points; where cornice-normals left all out, it said so and why");
  }
  const Box2d plan = tile.grown(command.halo_m);
  Box3d domain;
  for (const Vec3f p : points.positions) {
    const Vec3d at = points.origin + p.cast<double>();
    if (plan.contains(at.x, at.y) && std::isfinite(at.z)) domain.add(at);
  }
  if (domain.empty()) {
    throw InputError(command.points.string(),
                     "has no points in the tile and its halo; is --tile in the points' system?");
  }
  const double margin = std::max(kHeightMarginM, kHeightMarginSteps * command.solve.lattice.step_m);
  return {{plan.min_x, plan.min_y, domain.min.z - margin},
          {plan.max_x, plan.max_y, domain.max.z + margin}};
}

void report_solution(const SolveReport& solved, Report& report) {
  report.count("points", solved.points);
  report.count("not finite", solved.not_finite);
  report.count("without normal", solved.without_normal);
  report.count("outside tile and halo", solved.outside);
  report.quality("field at points", solved.field_at_points);
  nlohmann::json levels = nlohmann::json::array();
  for (const LevelReport& level : solved.levels) {
    levels.push_back({{"spacing_m", level.spacing_m},
                      {"bricks", level.bricks},
                      {"unknowns", level.unknowns},
                      {"residual", level.residual}});
  }
  report.quality("levels", levels);
  nlohmann::json seconds;
  for (const StepSeconds& step : solved.seconds) seconds[step.step] = step.seconds;
  report.quality("seconds of solving", seconds);
}

/// Puts points of the elevation model into the gaps of `points`.
void fill_gaps(Command& command, const LatticeBox& tile, OrientedPoints& points,
               StageContext& context) {
  if (command.fill_dem.empty()) return;
  const Lattice& lattice = command.solve.lattice;
  const Box2d area = box_in_metres(tile, lattice).grown(command.halo_m);
  // An empty cloud has no origin of its own, and one far away would cost floats their precision.
  if (points.positions.empty()) {
    points.origin = {std::floor(area.min_x), std::floor(area.min_y), 0.0};
  }
  command.fill.step_m = lattice.step_m;
  context.report.step("fill", [&] {
    const ElevationModel model = ElevationModel::read(command.fill_dem, points.crs_text, area);
    const std::uint64_t added = fill_gaps(points, model, area, command.fill);
    context.report.count("rasters used", model.rasters_used());
    context.report.count("points of the elevation model", added);
    if (model.without_vertical() > 0) {
      context.report.warn(std::to_string(model.without_vertical()) +
                          " rasters do not say what their heights refer to; they are taken to be "
                          "in the points' system");
    }
  });
}

TileField solve_tile(Command& command, OrientedPoints& points, StageContext& context) {
  command.solve.threads = context.options.threads;
  TileField tile;
  const Box2d box = tile_of(command, points);
  tile.tile = lattice_box(box, command.solve.lattice);
  tile.ramp = std::max(kLeastRamp, static_cast<std::int32_t>(
                                       std::lround(command.band_m / command.solve.lattice.step_m)));
  tile.crs_text = points.crs_text;
  const std::size_t measured = points.positions.size();
  fill_gaps(command, tile.tile, points, context);
  const Box3d domain = domain_of(command, box_in_metres(tile.tile, command.solve.lattice), points);
  const double step = command.solve.lattice.step_m;
  tile.z0 = static_cast<std::int32_t>(std::floor(domain.min.z / step));
  tile.z1 = static_cast<std::int32_t>(std::ceil(domain.max.z / step));
  context.report.step("solve", [&] {
    Solution solution = solve_poisson(points, domain, command.solve, context.progress);
    report_solution(solution.report, context.report);
    tile.field = std::move(solution.field);
  });
  points.positions.resize(measured);  // support is by measured points alone
  return tile;
}

void report_surface(const Surface& surface, Report& report) {
  report.count("triangles", surface.mesh.triangles.size());
  report.count("vertices", surface.mesh.positions.size());
  report.count("bricks with surface", surface.bricks);
  report.count("vertices made one of several", surface.welded);
  report.count("loops with a vertex in the middle", surface.centre_vertices);
  if (surface.mesh.triangles.empty()) report.warn("the field has no surface within the tile");
}

void add_support(const Command& command, const OrientedPoints& points, Mesh& mesh,
                 StageContext& context) {
  SupportOptions options = command.support;
  options.threads = context.options.threads;
  Support support;
  context.report.step("support",
                      [&] { support = measure_support(mesh, points, options, context.progress); });
  const auto measured = std::count_if(support.distance_m.begin(), support.distance_m.end(),
                                      [](float d) { return d <= kMeasuredM; });
  if (!support.distance_m.empty()) {
    context.report.quality(
        "share of vertices within 1 m of a point",
        static_cast<double>(measured) / static_cast<double>(support.distance_m.size()));
  }
  mesh.float_properties.push_back({"support", std::move(support.distance_m)});
  mesh.float_properties.push_back({"density", std::move(support.density)});
}

void write_mesh(const Command& command, const Mesh& mesh, StageContext& context) {
  context.report.step("write", [&] { write_ply(command.output, mesh); });
}

LatticeBox window_of(const Command& command, const TileField& tile) {
  const double step = tile.field.lattice().step_m;
  return tile.tile.grown(static_cast<std::int32_t>(std::lround(command.margin_m / step)));
}

/// The bands that the command names: as arguments, or in the list, by paths relative to it.
std::vector<std::filesystem::path> band_paths(const Command& command) {
  if (command.tile_list.empty()) return command.neighbours;
  if (!command.neighbours.empty()) {
    throw UsageError("--tiles", "and --neighbours say the same; give one of them");
  }
  check_input_file(command.tile_list);
  std::ifstream stream(command.tile_list);
  if (!stream) throw InputError(command.tile_list.string(), "cannot be read");
  std::vector<std::filesystem::path> paths;
  for (std::string line; std::getline(stream, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (!line.empty()) paths.push_back(command.tile_list.parent_path() / line);
  }
  return paths;
}

struct Neighbours {
  std::vector<TileField> bands;
  std::vector<std::string> names;  ///< the own tile's first
};

/// Reads the bands that lie close enough to matter. The own tile's band, and a band named twice,
/// are passed over.
Neighbours read_neighbours(const Command& command, const TileField& own, Report& report) {
  Neighbours read{{}, {command.field.string()}};
  std::vector<LatticeBox> seen{own.tile};
  const std::vector<std::filesystem::path> paths = band_paths(command);
  for (const std::filesystem::path& path : paths) {
    const FieldHead head = read_field_head(path);
    const bool is_new = std::find(seen.begin(), seen.end(), head.tile) == seen.end();
    // Tiles of another lattice or band go on to where they are refused by name.
    const bool comparable = head.lattice == own.field.lattice() && head.ramp == own.ramp;
    if (comparable && (!is_new || !head.tile.touches(own.tile.grown(2 * own.ramp)))) continue;
    report.add_input(path);
    seen.push_back(head.tile);
    read.bands.push_back(read_field(path));
    read.names.push_back(path.string());
  }
  report.count("bands given", paths.size());
  report.count("neighbours used", read.bands.size());
  return read;
}

}  // namespace

void run_solve(Command& command, StageContext& context) {
  if (command.band.empty()) {
    command.band = command.output;
    command.band.replace_extension(".band");
  }
  if (command.band == command.output) {
    throw UsageError("--band", "is the same file as --output; give another name");
  }
  check_output(command.band, context.options);
  if (command.halo_m < 2.0 * command.band_m) {
    context.report.warn("the halo of " + std::to_string(command.halo_m) +
                        " m is less than twice the band; neighbours may disagree there");
  }
  if (command.tile.empty()) {
    context.report.warn(
        "without --tile the tile is the points' own box; neighbours may not share "
        "a border with it");
  }
  context.memory.charge("points and their field",
                        read_ply_info(command.points).count("vertex") * kBytesPerPointSolved);
  OrientedPoints points = read_points(command.points, context);
  const TileField tile = solve_tile(command, points, context);
  TileField band;
  context.report.step("band", [&] { band = make_band(tile); });
  context.report.step("write", [&] {
    // The band first: whoever sees the field finds its band beside it.
    write_field(command.band, band);
    write_field(command.output, tile);
  });
  context.report.add_output(command.band);
}

void run_extract(Command& command, StageContext& context) {
  Report& report = context.report;
  const bool with_neighbours = !command.neighbours.empty() || !command.tile_list.empty();
  if (with_neighbours && command.margin_m > 0.0) {
    throw UsageError("--margin-m", "is for tiles without neighbours; leave it out");
  }
  report.add_input(command.field);
  context.memory.charge("the field", 2 * std::filesystem::file_size(command.field));
  TileField own;
  Neighbours neighbours;
  report.step("read field", [&] {
    own = read_field(command.field);
    if (own.is_band) {
      throw InputError(command.field.string(), "is a border band; give the field beside it");
    }
    neighbours = read_neighbours(command, own, report);
  });
  const BlendedValues values(own, neighbours.bands, neighbours.names);
  command.extract.window = window_of(command, own);
  command.extract.borders = values.tiles();
  command.extract.threads = context.options.threads;
  Surface surface;
  report.step("extract", [&] {
    surface = extract_surface(values, own.field.lattice(), command.extract, context.progress);
  });
  surface.mesh.crs_text = own.crs_text;
  report_surface(surface, report);
  if (command.points.empty()) {
    report.warn("without --points the mesh has no support; trimming needs it");
  } else {
    context.memory.charge("points",
                          read_ply_info(command.points).count("vertex") * kBytesPerPointSupport);
    const OrientedPoints points = read_points(command.points, context);
    if (points.crs_text != own.crs_text) {
      throw InputError(command.points.string(),
                       "is in " + points.crs_text + ", but the field in " + own.crs_text);
    }
    add_support(command, points, surface.mesh, context);
  }
  write_mesh(command, surface.mesh, context);
}

void run_mesh(Command& command, StageContext& context) {
  context.memory.charge("points and their field",
                        read_ply_info(command.points).count("vertex") * kBytesPerPointSolved);
  OrientedPoints points = read_points(command.points, context);
  TileField tile = solve_tile(command, points, context);
  command.extract.window = window_of(command, tile);
  command.extract.threads = context.options.threads;
  Surface surface;
  context.report.step("extract", [&] {
    surface = extract_surface(FieldValues(tile.field, tile.z0, tile.z1), tile.field.lattice(),
                              command.extract, context.progress);
  });
  tile.field = Field();
  surface.mesh.crs_text = points.crs_text;
  report_surface(surface, context.report);
  add_support(command, points, surface.mesh, context);
  write_mesh(command, surface.mesh, context);
}

}  // namespace cornice::poisson
