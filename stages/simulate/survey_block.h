// SPDX-License-Identifier: GPL-3.0-or-later
// The points of a run of consecutive pulses.
#pragma once

#include <cstdint>
#include <vector>

#include "stages/simulate/defects.h"
#include "stages/simulate/products.h"
#include "stages/simulate/returns.h"
#include "stages/simulate/scanner.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/survey_point.h"
#include "stages/simulate/trajectory.h"

namespace cornice::simulate {

/// All that the points of a survey are a function of. Everything outlives its use here.
/// Thread contract: read only.
struct SurveySetup {
  const Scene* scene = nullptr;
  HeightBounds heights;  ///< of the scene
  const Trajectory* trajectory = nullptr;
  const Scanner* scanner = nullptr;
  int channels = 1;
  std::vector<SurveyLine> lines;  ///< channels per pass
  DefectOptions defects;
  NoiseOptions noise;
  SurveyProduct product = SurveyProduct::kSwissSurface3d;
  int most_returns = 5;
  TileGrid grid;
  double pulse_rate = 1e5;  ///< pulses per second of each channel
  std::uint64_t seed = 1;
};

/// Pulses [first, first + count) of one pass.
struct PulseBlock {
  std::size_t pass = 0;
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

/// What the tiles hold of a line, with all defects but that of zero times.
struct LineTally {
  std::uint64_t points = 0;
  double first_time_s = 0.0;  ///< as recorded
  double last_time_s = 0.0;
  double true_first_time_s = 0.0;  ///< adjusted standard time
  double true_last_time_s = 0.0;
  double lowest_angle_deg = 0.0;  ///< true, positive to the right
  double highest_angle_deg = 0.0;

  /// Adds the tally of later points.
  void add(const LineTally& later);
};

/// Points of a block, and per channel what of them belongs to its line.
struct BlockPoints {
  std::vector<SurveyPoint> points;
  std::vector<LineTally> tallies;
};

/// Pulses of a pass.
std::uint64_t pulses_of_pass(const SurveySetup& setup, std::size_t pass);

/// Points of a block inside the grid, in time order (at one time: channel by channel, return by
/// return), with all defects but those of order. Depends on nothing but its arguments.
BlockPoints simulate_block(const SurveySetup& setup, const PulseBlock& block);

/// Virtual points of class 66 of one tile (DefectOptions::virtual_on_water, virtual_everywhere).
std::vector<SurveyPoint> virtual_points(const SurveySetup& setup, int tile);

}  // namespace cornice::simulate
