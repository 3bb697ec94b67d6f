// SPDX-License-Identifier: GPL-3.0-or-later
// The viewer's command line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/cli/options.h"
#include "terrain-viewer/scene/style.h"

namespace cornice::viewer {

/// From where a picture is taken when no camera is given.
enum class Viewpoint { kAll, kOverview, kSteepest };

struct Options {
  std::vector<std::filesystem::path> files;
  bool headless = false;
  std::filesystem::path camera, path, save_camera;
  std::string size = "1280x720";
  std::filesystem::path output;
  double error_pixels = 2.0;
  int samples = 4;
  double gpu_memory_mib = 1024.0;
  double cache_mib = 1024.0;
  int loading_threads = 2;
  double triangle_budget_m = 0.0;
  double frame_ms = 0.0;
  bool streams = false;
  bool side_by_side = false;
  Shading shading = Shading::kNatural;
  std::string time;
  std::optional<double> sun_azimuth_deg;
  double sun_elevation_deg = 45.0;
  double contour_interval_m = 0.0;
  std::optional<double> snow_line_m, tree_line_m;
  std::vector<std::filesystem::path> orthophoto;
  std::filesystem::path difference;
  std::optional<double> difference_range_m;
  double drape_memory_mib = 256.0;
  bool has_edges = false;
  bool has_sky = true;
  bool has_legend = false;
  Viewpoint viewpoint = Viewpoint::kAll;
};

std::vector<Option> describe(Options& options);

/// Width and height of "1280x720". Throws UsageError.
struct PixelSize {
  int width = 0, height = 0;
};
PixelSize parse_size(const std::string& text);

}  // namespace cornice::viewer
