// SPDX-License-Identifier: GPL-3.0-or-later
// What is known of a path before any pulse: priors on its means, and how an aircraft moves.
// Internal to the path solver.
#pragma once

#include <vector>

#include "stages/flightlines/path_model.h"

namespace cornice::flightlines {

/// What priors refer to.
struct PathPrior {
  Eigen::Vector3d middle;  ///< of the pulses
  ScanModel model = ScanModel::kNone;
  double yaw_sigma_deg = 0.02;  ///< of a plane against the heading
};

/// Priors on means: each is one observation, shared by all nodes.
void add_priors(const std::vector<State>& states, const Common& common, const PathPrior& prior,
                const TrajectoryOptions& options, PathSystem& system);

/// Smoothness: velocity, heading and axis walk randomly, position follows velocity.
void add_motion(const std::vector<State>& states, double step_s, const TrajectoryOptions& options,
                PathSystem& system);

}  // namespace cornice::flightlines
