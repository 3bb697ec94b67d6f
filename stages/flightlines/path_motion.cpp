// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/path_motion.h"

#include <algorithm>
#include <cmath>

#include "stages/flightlines/robust.h"

namespace cornice::flightlines {
namespace {

/// Of the path's height above the ground, before anything is known.
constexpr double kLikelyHeightM = 1500.0;
constexpr double kHeightSigmaM = 3000.0;
constexpr double kPlaceSigmaM = 5000.0;

/// Unknown `i` changes from node `k` to the next by no more than `sigma`.
void add_walk(const State& step, std::size_t k, int i, double sigma, PathSystem& system) {
  const double weight = 1.0 / (sigma * sigma);
  system.diagonal[k](i, i) += weight;
  system.diagonal[k + 1](i, i) += weight;
  system.upper[k](i, i) -= weight;
  system.right[k](i) += weight * step(i);
  system.right[k + 1](i) -= weight * step(i);
}

/// Position `i` follows velocity: e = p' - p - step (v + v') / 2.
void add_flow(const State& from, const State& to, std::size_t k, int i, double step_s, double sigma,
              PathSystem& system) {
  const double weight = 1.0 / (sigma * sigma);
  const int v = kVelocity + i;
  const double half = 0.5 * step_s;
  const double e = to(i) - from(i) - half * (from(v) + to(v));
  const Eigen::Vector2d before(-1.0, -half), after(1.0, -half);
  const int index[2] = {i, v};
  for (const int r : {0, 1}) {
    for (const int c : {0, 1}) {
      system.diagonal[k](index[r], index[c]) += weight * before(r) * before(c);
      system.diagonal[k + 1](index[r], index[c]) += weight * after(r) * after(c);
      system.upper[k](index[r], index[c]) += weight * before(r) * after(c);
    }
    system.right[k](index[r]) -= weight * e * before(r);
    system.right[k + 1](index[r]) -= weight * e * after(r);
  }
}

void add_common_priors(const Common& common, const PathPrior& prior,
                       const TrajectoryOptions& options, PathSystem& system) {
  const auto add = [&](int i, double value, double sigma) {
    system.corner(i, i) += 1.0 / (sigma * sigma);
    system.corner_right(i) -= value / (sigma * sigma);
  };
  add(kOffset, common(kOffset), options.angle_offset_sigma_deg * kRadians);
  if (prior.model == ScanModel::kCone)
    add(kShape, common(kShape) - options.cone_deg * kRadians, options.cone_sigma_deg * kRadians);
  else
    add(kShape, common(kShape), prior.yaw_sigma_deg * kRadians);
}

}  // namespace

void add_priors(const std::vector<State>& states, const Common& common, const PathPrior& prior,
                const TrajectoryOptions& options, PathSystem& system) {
  const double share = 1.0 / static_cast<double>(states.size());
  for (std::size_t k = 0; k < states.size(); ++k) {
    const State& x = states[k];
    const auto add = [&](int i, double value, double sigma) {
      const double weight = share / (sigma * sigma);
      system.diagonal[k](i, i) += weight;
      system.right[k](i) -= weight * value;
    };
    add(0, x(0) - prior.middle.x(), kPlaceSigmaM);
    add(1, x(1) - prior.middle.y(), kPlaceSigmaM);
    add(2, x(2) - prior.middle.z() - kLikelyHeightM, kHeightSigmaM);
    const double course = std::atan2(x(kVelocity), x(kVelocity + 1));
    add(kHeading, std::remainder(x(kHeading) - course, 2.0 * std::numbers::pi),
        options.crab_sigma_deg * kRadians);
    add(kAxisSide, x(kAxisSide), options.attitude_sigma_deg * kRadians);
    add(kAxisFore, x(kAxisFore), options.attitude_sigma_deg * kRadians);
    const double speed = std::hypot(x(kVelocity), x(kVelocity + 1));
    for (const int i : {0, 1}) {
      const double unit = x(kVelocity + i) / std::max(speed, 1.0);
      add(kVelocity + i, (speed - options.speed_ms) * unit, options.speed_sigma_ms);
    }
    add(kVelocity + 2, x(kVelocity + 2), options.climb_sigma_ms);
  }
  add_common_priors(common, prior, options, system);
}

void add_motion(const std::vector<State>& states, double step_s, const TrajectoryOptions& options,
                PathSystem& system) {
  const double root = std::sqrt(step_s);
  const double velocity_sigma = options.velocity_walk_ms * root;
  const double position_sigma = velocity_sigma * step_s / std::sqrt(12.0);
  const double heading_sigma = options.heading_walk_deg * kRadians * root;
  const double axis_sigma = options.attitude_walk_deg * kRadians * root;
  for (std::size_t k = 0; k + 1 < states.size(); ++k) {
    const State step = states[k + 1] - states[k];
    add_walk(step, k, kHeading, heading_sigma, system);
    add_walk(step, k, kAxisSide, axis_sigma, system);
    add_walk(step, k, kAxisFore, axis_sigma, system);
    for (const int i : {0, 1, 2}) {
      add_walk(step, k, kVelocity + i, velocity_sigma, system);
      add_flow(states[k], states[k + 1], k, i, step_s, position_sigma, system);
    }
  }
}

}  // namespace cornice::flightlines
