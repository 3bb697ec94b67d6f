// SPDX-License-Identifier: GPL-3.0-or-later
// The pulses of a pass as the path solver takes them. Internal to the path solver.
#pragma once

#include <cstddef>
#include <vector>

#include "stages/flightlines/line_split.h"
#include "stages/flightlines/path_model.h"

namespace cornice::flightlines {

/// Nodes at equal steps of time, and the point that coordinates are relative to.
struct PathGrid {
  double start_time_s = 0.0;
  double step_s = 0.25;
  std::size_t nodes = 2;
  Vec3d origin;

  PathGrid(const LinePass& pass, double node_step_s);
  double time_s(std::size_t node) const {
    return start_time_s + static_cast<double>(node) * step_s;
  }
};

struct PathPulses {
  std::vector<Observation> observations;
  std::vector<bool> seen;  ///< by node: some pulse lies next to it
  std::size_t angles = 0;
  std::size_t pairs = 0;
  bool whole_degrees = true;
};

/// `sign`: of the recorded angle, 0 leaves angles out. `model`: single pulses take part by their
/// angle and by the model; where there is neither, only first-last lines do.
PathPulses collect_pulses(const LinePass& pass, const PathGrid& grid, int sign, ScanModel model,
                          const TrajectoryOptions& options);

}  // namespace cornice::flightlines
