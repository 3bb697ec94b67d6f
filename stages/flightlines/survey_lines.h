// SPDX-License-Identifier: GPL-3.0-or-later
// The flight lines of a survey, from its tiles one after the other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/memory.h"
#include "core/base/progress.h"
#include "core/geo/crs.h"
#include "core/points/flight_line.h"
#include "stages/flightlines/line_estimate.h"
#include "stages/flightlines/line_split.h"
#include "stages/flightlines/overlap.h"
#include "stages/flightlines/pulse_bins.h"
#include "stages/flightlines/trajectory.h"

namespace cornice::flightlines {

struct SurveyOptions {
  std::string crs;             ///< --crs: replaces what the files say; empty: their own
  bool keep_readable = false;  ///< take the points before the place where a file is damaged
  bool overlaps = true;        ///< height mismatch of overlapping lines
  int threads = 1;             ///< 0: all cores
  SampleSize sample;
  SplitOptions split;
  TrajectoryOptions trajectory;
  AcceptOptions accept;
};

/// What one tile gave.
struct TileCounts {
  std::filesystem::path file;
  std::uint64_t points = 0;
  std::uint64_t valid_points = 0;
  InvalidCounts invalid{};
  std::string problem;  ///< why reading stopped early; empty where the file was whole
};

struct SurveyLines {
  Crs crs;
  std::vector<LineEstimate> lines;  ///< ids from 1, by first time
  std::vector<OverlapPair> overlaps;
  std::vector<TileCounts> tiles;
  InvalidCounts invalid{};
  SplitCounts split;
  std::uint64_t points = 0;
  std::uint64_t valid_points = 0;
  bool channel_in_user_data = false;
  std::size_t signs_settled = 0;    ///< lines whose sign is that of the others
  std::size_t sample_halvings = 0;  ///< to stay within the memory
  double binning_s = 0.0;           ///< in our own code, without decoding
  double estimate_s = 0.0;
  std::vector<std::string> warnings;

  FlightLines flight_lines() const;
};

/// What is kept of one tile while its points pass by.
class TileReader {
 public:
  /// `corner`: of the tile, metres; `points_per_m2`: of all lines.
  TileReader(const SurveyOptions& options, const SampleSize& sample, Vec3d corner,
             double points_per_m2);
  /// Bins and height grids side by side; `metres` scale plan and height.
  void add(const PointCloud& points, double metres = 1.0, double metres_up = 1.0);
  /// Merges the tile into what is known of the survey; the counts lack the file's name.
  TileCounts finish(const std::string& file, BinSet& bins, SheetPairs& pairs);

 private:
  SampleSize sample_;
  bool overlaps_;
  int threads_;
  TileBinner binner_;
  TileOverlap overlap_;
};

/// Reads the tiles in the order given and estimates the lines of them all. Memory: one chunk of
/// points, one tile's cells and a bounded sample of pulses. The result does not depend on the order
/// of the tiles or on threads. Throws InputError where tiles differ in CRS or are in degrees.
SurveyLines find_survey_lines(const std::vector<std::filesystem::path>& files,
                              const SurveyOptions& options, MemoryBudget& memory,
                              Progress& progress = no_progress());

/// The part of find_survey_lines after reading.
void estimate_survey(BinSet&& bins, const SheetPairs& pairs, const SurveyOptions& options,
                     SurveyLines& survey, Progress& progress = no_progress());

}  // namespace cornice::flightlines
