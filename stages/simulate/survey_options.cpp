// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/survey_options.h"

#include <charconv>
#include <chrono>
#include <cmath>

#include "core/base/error.h"

namespace cornice::simulate {
namespace {

constexpr int kMostTilesPerSide = 100;

int tile_number(const std::string& text, const std::string& all) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 1 ||
      value > kMostTilesPerSide)
    throw UsageError("--tiles", "\"" + all + "\" must be COLUMNSxROWS, 1x1 to 100x100");
  return value;
}

/// 0, or a step that fits into a tile.
void check_step(const char* option, double step_m, double tile_m) {
  constexpr double kLeastStepM = 0.05;
  if (step_m == 0.0 || (step_m >= kLeastStepM && step_m <= tile_m)) return;
  throw UsageError(option, "must be 0 or from 0.05 m to the side of a tile");
}

}  // namespace

std::vector<Option> describe_scene(SurveyOptions& o) {
  return {
      Option("product", o.product,
             {{"swisssurface3d", SurveyProduct::kSwissSurface3d},
              {"lidarhd", SurveyProduct::kLidarHd}},
             "whose tiles to write: format, CRS, names, classes"),
      Option("container", o.container,
             {{"laz", TileContainer::kLaz},
              {"las", TileContainer::kLas},
              {"las.zip", TileContainer::kZippedLas},
              {"copc", TileContainer::kCopc}},
             "what tiles are packed in; copc holds one tile in memory at a time"),
      Option("tiles", o.tiles, "columns x rows of tiles"),
      Option("tile-size", o.tile_m, "side of a tile, whole metres").range(10, 10000).unit("m"),
      Option("corner", o.corner,
             "easting,northing of the south-west corner, whole metres; "
             "default: a mountain tile of the product"),
      Option("seed", o.seed, "another seed, another scene, flight and noise"),
      Option("year", o.year, "of the flight").range(2012, 2099).advanced(),
      Option("defects", o.defects, "what goes wrong, NAME or NAME=VALUE, by commas; see README"),
  };
}

std::vector<Option> describe_flight(SurveyOptions& o) {
  return {
      Option("density", o.density, "points of all returns over the tiles")
          .range(0.01, 500)
          .unit("points/m2"),
      Option("height", o.flight.height_m, "of flight above the mean ground")
          .range(50, 20000)
          .unit("m"),
      Option("overlap", o.overlap_percent, "of neighbouring swaths on the highest ground")
          .range(0, 80)
          .unit("%"),
      Option("azimuth", o.flight.azimuth_deg, "of the first line, clockwise from north")
          .range(-360, 360)
          .unit("deg"),
      Option("cross-line", o.flight.cross_line, "flies one more line across the others"),
      Option("speed", o.flight.speed_ms, "over ground").range(10, 200).unit("m/s"),
      Option("motion", o.flight.motion, "unrest of the aircraft, 0: none").range(0, 3).advanced(),
      Option("turn", o.flight.turn_s, "time from line to line")
          .range(10, 3000)
          .unit("s")
          .advanced(),
      Option("noise", o.noise_m, "standard deviation of a point in space").range(0, 1).unit("m"),
  };
}

std::vector<Option> describe_scanner(SurveyOptions& o) {
  return {
      Option("scanner", o.scanner.pattern,
             {{"oscillating", ScannerPattern::kOscillating},
              {"polygon", ScannerPattern::kPolygon},
              {"palmer", ScannerPattern::kPalmer}},
             "swinging mirror, rotating polygon or cone"),
      Option("fov", o.scanner.fov_deg, "full field of view, 0: 40, 60 or 36 by scanner")
          .range(0, 100)
          .unit("deg"),
      Option("tilt", o.scanner.tilt_deg, "lean of the scan plane towards the nose")
          .range(-30, 30)
          .unit("deg"),
      Option("channels", o.scanner.channels, "2: a second channel fires at the same time stamps")
          .range(1, 2),
      Option("second-tilt", o.scanner.second_tilt_deg, "lean of the second channel")
          .range(-30, 30)
          .unit("deg")
          .advanced(),
      Option("channel-tag", o.channel_tag,
             {{"source-id", ChannelTag::kPointSourceId},
              {"channel", ChannelTag::kScannerChannel},
              {"user-data", ChannelTag::kUserData}},
             "field that tells two channels apart")
          .advanced(),
      Option("mirror-sharpness", o.scanner.mirror_sharpness,
             "of the swinging mirror, 0: sine, 0.999: triangle")
          .range(0, 0.999)
          .advanced(),
  };
}

std::vector<Option> describe_truth(SurveyOptions& o) {
  return {
      Option("truth", o.truth,
             {{"ply", PointTruth::kPly},
              {"extra-bytes", PointTruth::kExtraBytes},
              {"none", PointTruth::kNone}},
             "where the truth of every point goes"),
      Option("truth-mesh-step", o.truth_mesh_step_m, "of the ground's mesh, 0: no mesh")
          .range(0, 100)
          .unit("m"),
      Option("truth-dem-step", o.truth_dem_step_m, "of the ground's DEM, 0: no DEM")
          .range(0, 100)
          .unit("m"),
      Option("trajectory-step", o.flight.node_step_s, "between poses of the true trajectory")
          .range(0.001, 0.1)
          .unit("s")
          .advanced(),
  };
}

TileGrid tile_grid(const SurveyOptions& options) {
  const std::size_t cross = options.tiles.find('x');
  if (cross == std::string::npos)
    throw UsageError("--tiles", "\"" + options.tiles + "\" must be COLUMNSxROWS, 1x1 to 100x100");
  if (std::floor(options.tile_m) != options.tile_m)
    throw UsageError("--tile-size", "must be whole metres, is " + std::to_string(options.tile_m));
  if (!options.corner.empty() &&
      (options.corner.size() != 2 || std::floor(options.corner[0]) != options.corner[0] ||
       std::floor(options.corner[1]) != options.corner[1] ||
       std::max(std::abs(options.corner[0]), std::abs(options.corner[1])) > 1e7))
    throw UsageError("--corner", "must be EASTING,NORTHING in whole metres, 1e7 at most");
  TileGrid grid;
  const Vec3d corner = options.corner.empty() ? default_corner(options.product)
                                              : Vec3d{options.corner[0], options.corner[1], 0.0};
  grid.west = corner.x;
  grid.south = corner.y;
  grid.tile_m = options.tile_m;
  grid.columns = tile_number(options.tiles.substr(0, cross), options.tiles);
  grid.rows = tile_number(options.tiles.substr(cross + 1), options.tiles);
  return grid;
}

void check(const SurveyOptions& options) {
  tile_grid(options);
  check(options.scanner);
  check_step("--truth-mesh-step", options.truth_mesh_step_m, options.tile_m);
  check_step("--truth-dem-step", options.truth_dem_step_m, options.tile_m);
  const double pixels = options.tile_m / options.truth_dem_step_m;
  if (options.truth_dem_step_m > 0.0 && std::abs(pixels - std::round(pixels)) > 1e-9)
    throw UsageError("--truth-dem-step", "must divide the side of a tile");
  const DefectOptions defects = parse_defects(options.product, options.defects);
  const bool is_old = stores_whole_degrees(options.product, options.container);
  if (is_old && options.scanner.channels > 1 && options.channel_tag == ChannelTag::kScannerChannel)
    throw UsageError("--channel-tag",
                     "point format 1 has no scanner channel; use source-id or user-data, or "
                     "--container copc");
  if (options.container == TileContainer::kCopc && defects.unordered)
    throw UsageError("--defects", "unordered: COPC has its own order; use --container laz");
}

double start_time_s(int year) {
  using namespace std::chrono;
  // GPS time starts on 1980-01-06; adjusted standard time is less by 1e9 s. Leap seconds, some 18
  // by now, do not matter to when a flight is.
  const sys_days epoch{1980y / January / 6};
  const sys_days day{std::chrono::year{year} / June / 15};
  constexpr double kMorning = 8.0 * 3600.0;
  return static_cast<double>((day - epoch).count()) * 86400.0 + kMorning - 1e9;
}

}  // namespace cornice::simulate
