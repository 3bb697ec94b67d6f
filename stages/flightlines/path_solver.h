// SPDX-License-Identifier: GPL-3.0-or-later
// Gauss-Newton over the nodes of a path. Internal to trajectory.cpp.
#pragma once

#include <vector>

#include "stages/flightlines/path_motion.h"
#include "stages/flightlines/path_pulses.h"

namespace cornice::flightlines {

class PathSolver {
 public:
  /// `sign` and `model` as for solve_path.
  PathSolver(const LinePass& pass, const TrackFit& start, int sign, ScanModel model,
             const TrajectoryOptions& options);
  bool is_solvable() const { return pulses_.pairs >= 12 || (pulses_.angles >= 40 && sign_ != 0); }
  /// Takes position, velocity and heading over, of the same scan model its shape too.
  void start_from(const PathEstimate& warm);
  PathEstimate run();

 private:
  /// Robust scales of the three kinds of residuals.
  struct Scales {
    double angle = 0.0;  ///< radians
    double scan = 0.0;   ///< radians
    double pair = 1.0;   ///< factor on the expected error
  };

  void start_states(const TrackFit& start);
  void start_cone();
  Seen seen_at(const Observation& o) const;
  void weigh(bool is_early);
  void weigh_ends(const std::vector<double>& off);
  void add_observations(PathSystem& system) const;
  double apply(const PathSolution& solution);
  void keep_to_course(State& x) const;
  double cost_per_pulse() const;
  PathNode node_of(std::size_t k, const PathSolution& solution) const;
  PathEstimate result(const PathSolution& solution) const;

  TrajectoryOptions options_;
  ScanModel model_;
  int sign_;  ///< +1, -1, or 0 where angles are not used
  PathGrid grid_;
  PathPulses pulses_;
  PathPrior prior_;
  std::vector<State> states_;
  Common common_ = Common::Zero();
  Scales scales_;
  bool is_warm_ = false;
  bool by_ends_ = false;  ///< whole degrees count by their ends
};

}  // namespace cornice::flightlines
