// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-picture: rasters as relief, or points and meshes seen obliquely or from above.
#include <algorithm>
#include <initializer_list>
#include <optional>

#include "core/base/error.h"
#include "core/cli/stage.h"
#include "core/io/flight_lines_file.h"
#include "core/io/las.h"
#include "core/io/ply.h"
#include "pipeline/pictures/mesh_view.h"
#include "pipeline/pictures/oblique.h"
#include "pipeline/pictures/relief.h"

namespace {

using namespace cornice;

/// Arguments of the program.
struct Arguments {
  std::vector<std::filesystem::path> files;
  std::filesystem::path output;
  std::string colour = "auto";
  std::string view_name = "oblique";
  std::filesystem::path flight_lines;
  pictures::View view;
};

bool ends_with(const std::filesystem::path& path, std::initializer_list<const char*> endings) {
  const std::string name = path.filename().string();
  return std::any_of(endings.begin(), endings.end(),
                     [&](const char* ending) { return name.ends_with(ending); });
}

/// Adds points whose origin is `origin` to those of the first file, whose origin counts.
void add_position(pictures::ColouredPoints& all, const Vec3d& shift, Vec3f position,
                  pictures::Rgb colour) {
  all.positions.push_back(position + shift.cast<float>());
  all.colours.push_back(colour);
}

void add_las(const Arguments& arguments, const FlightLines& lines, const LasInfo& info,
             const StageContext& context, pictures::ColouredPoints& all,
             std::optional<Vec3d>& origin) {
  LasReadOptions options;
  options.threads = context.options.threads;
  options.attributes = Attribute::kClassification | Attribute::kPointSource | Attribute::kGpsTime |
                       Attribute::kChannel | Attribute::kUserData;
  const PointCloud points = read_las(info, options, context.progress).points;
  if (!origin) origin = points.origin;
  LineFinder finder(lines);
  for (std::size_t i = 0; i < points.size(); ++i) {
    pictures::Rgb colour = pictures::class_colour(points.classification[i]);
    if (arguments.colour == "line") {
      const auto channel =
          points.scanner_channel.empty() ? std::uint8_t{0} : points.scanner_channel[i];
      const auto line = points.gps_time_s.empty()
                            ? std::nullopt
                            : finder.find(points.point_source_id[i], channel, points.gps_time_s[i],
                                          points.user_data[i]);
      // Grey: a point of no line, such as the virtual points of some products.
      colour = line ? pictures::number_colour(lines.lines[*line].id) : pictures::Rgb{170, 170, 170};
    }
    add_position(all, points.origin - *origin, points.positions[i], colour);
  }
}

void add_ply(const std::filesystem::path& file, pictures::ColouredPoints& all,
             std::optional<Vec3d>& origin) {
  const OrientedPoints points = read_ply_points(file);
  if (points.normals.size() != points.positions.size()) {
    throw InputError(file.string(), "has no normals to colour by");
  }
  if (!origin) origin = points.origin;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    add_position(all, points.origin - *origin, points.positions[i],
                 pictures::normal_colour(points.normals[i]));
  }
}

Picture picture_of_points(const Arguments& arguments, const FlightLines& lines,
                          const StageContext& context) {
  pictures::ColouredPoints all;
  std::optional<Vec3d> origin;
  for (const std::filesystem::path& file : arguments.files) {
    if (ends_with(file, {".ply"})) {
      add_ply(file, all, origin);
    } else {
      add_las(arguments, lines, read_las_info(file), context, all, origin);
    }
  }
  if (all.positions.empty()) {
    throw InputError(arguments.files.front().string(), arguments.files.size() > 1
                                                           ? "and the others hold no points to draw"
                                                           : "holds no points to draw");
  }
  return pictures::oblique_picture(all, arguments.view);
}

Picture picture_of_raster(const Arguments& arguments, const FlightLines& lines) {
  std::vector<Raster> parts;
  for (const std::filesystem::path& file : arguments.files) parts.push_back(read_raster(file));
  const Raster raster = pictures::merged(parts);
  Picture picture = pictures::relief_picture(raster);
  if (lines.lines.empty()) return picture;
  const int margin_px = picture.width / 8;
  picture = pictures::with_margin(picture, margin_px);
  pictures::draw_trajectories(picture, raster, lines, margin_px);
  return picture;
}

/// The picture of meshes; nothing where the files are points.
std::optional<Picture> picture_of_meshes(const Arguments& arguments) {
  if (!ends_with(arguments.files.front(), {".ply"})) return std::nullopt;
  if (read_ply_info(arguments.files.front()).count("face") == 0) return std::nullopt;
  std::vector<Mesh> meshes;
  for (const std::filesystem::path& file : arguments.files) meshes.push_back(read_ply_mesh(file));
  const auto colour = arguments.colour == "support" ? pictures::MeshColour::kSupport
                                                    : pictures::MeshColour::kRelief;
  return pictures::mesh_picture(meshes, arguments.view, colour);
}

void run(Arguments& arguments, StageContext& context) {
  if (arguments.view_name == "plan") {
    arguments.view.heading_deg = 0.0;
    arguments.view.tilt_deg = 90.0;
  }
  FlightLines lines;
  if (!arguments.flight_lines.empty()) lines = read_flight_lines(arguments.flight_lines);
  const bool raster = ends_with(arguments.files.front(), {".tif", ".tiff"});
  if (arguments.colour == "line" && lines.lines.empty()) {
    throw UsageError("--colour", "\"line\" needs --flightlines");
  }
  if (raster) return write_picture(arguments.output, picture_of_raster(arguments, lines));
  if (const auto meshes = picture_of_meshes(arguments))
    return write_picture(arguments.output, *meshes);
  write_picture(arguments.output, picture_of_points(arguments, lines, context));
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  pictures::View& view = arguments.view;
  Stage stage;
  stage.name = "picture";
  stage.description = "Shows rasters as relief, points and meshes obliquely or from above";
  stage.options = {
      Option("FILE", arguments.files,
             "GeoTIFF files of heights, LAS, LAZ or PLY files of points, or PLY meshes")
          .positional()
          .required(),
      output_option(arguments.output, "picture, PNG or JPEG"),
      Option("colour", arguments.colour,
             "of LAS points: class (auto) or line; of meshes: relief (auto) or support")
          .words({"auto", "class", "line", "relief", "support"}),
      Option("view", arguments.view_name, "from where; plan is from straight above, north up")
          .words({"oblique", "plan"}),
      Option("flightlines", arguments.flight_lines, "lines that cornice-flightlines wrote"),
      Option("heading", view.heading_deg, "looked along, from north").range(-360, 360).unit("deg"),
      Option("tilt", view.tilt_deg, "of the view below the horizon").range(5, 90).unit("deg"),
      Option("width", view.width_px, "of the picture").range(64, 8192).unit("px")};
  stage.examples = {"cornice-picture dem/*.tif -o relief.png",
                    "cornice-picture tiles/*.laz --colour class -o classes.png"};
  stage.run = [&](StageContext& context) { run(arguments, context); };
  return run_stage(argc, argv, std::move(stage));
}
