// SPDX-License-Identifier: GPL-3.0-or-later
// Options of cornice-simulate.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/cli/options.h"
#include "stages/simulate/defects.h"
#include "stages/simulate/products.h"
#include "stages/simulate/scanner.h"
#include "stages/simulate/survey_tiles.h"
#include "stages/simulate/trajectory.h"

namespace cornice::simulate {

/// What to survey and how; angles in degrees, lengths in metres.
struct SurveyOptions {
  std::filesystem::path scene_file;
  std::uint64_t seed = 1;  ///< of scene, flight and noise

  SurveyProduct product = SurveyProduct::kSwissSurface3d;
  TileContainer container = TileContainer::kLaz;
  std::string tiles = "1x1";   ///< columns x rows
  double tile_m = 1000.0;      ///< whole metres
  std::vector<double> corner;  ///< south-west, "E,N", whole metres; empty: default_corner()
  int year = 2021;

  double density = 20.0;  ///< points/m2 over all, every return counted
  ScannerOptions scanner;
  ChannelTag channel_tag = ChannelTag::kPointSourceId;
  FlightOptions flight;  ///< start_time_s and survey_break_s follow from the year and the defects
  double overlap_percent = 30.0;
  double noise_m = 0.03;
  std::vector<std::string> defects;

  PointTruth truth = PointTruth::kPly;
  double truth_mesh_step_m = 0.0;  ///< 0: no mesh
  double truth_dem_step_m = 2.0;   ///< 0: no DEM
};

/// In the order of the help text. Refers to `options`.
std::vector<Option> describe_scene(SurveyOptions& options);
std::vector<Option> describe_flight(SurveyOptions& options);
std::vector<Option> describe_scanner(SurveyOptions& options);
std::vector<Option> describe_truth(SurveyOptions& options);

/// Tiles asked for. Throws UsageError for a bad --tiles, --tile-size or --corner.
TileGrid tile_grid(const SurveyOptions& options);

/// Throws UsageError for fields out of range or at odds with each other.
void check(const SurveyOptions& options);

/// Adjusted standard GPS time of a June morning of the year.
double start_time_s(int year);

}  // namespace cornice::simulate
