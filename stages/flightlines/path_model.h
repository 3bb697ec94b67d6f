// SPDX-License-Identifier: GPL-3.0-or-later
// What one pulse says of the sensor's path: residuals and their derivatives. Internal to the path
// solver.
#pragma once

#include <Eigen/Dense>
#include <cstddef>

#include "core/base/vec.h"
#include "stages/flightlines/block_solver.h"
#include "stages/flightlines/trajectory.h"

namespace cornice::flightlines {

// State of a node: 0-2 position, 3 heading, 4-5 axis of the scanner, 6-8 velocity. Pulses touch the
// first six only.
inline constexpr int kState = 9;
inline constexpr int kSeen = 6;
inline constexpr int kHeading = 3;
inline constexpr int kAxisSide = 4;  ///< cone: lean to the right, tangent
inline constexpr int kAxisFore = 5;  ///< plane: pitch of its normal, radians; cone: fore, tangent
inline constexpr int kVelocity = 6;
// Common unknowns: half angle of the cone or yaw of the plane against the heading; angle offset.
inline constexpr int kCommon = 2;
inline constexpr int kShape = 0;
inline constexpr int kOffset = 1;

using PathSystem = BlockSystem<kState, kCommon>;
using PathSolution = BlockSolution<kState, kCommon>;
using State = Eigen::Matrix<double, kState, 1>;
using Seen = Eigen::Matrix<double, kSeen, 1>;
using Common = Eigen::Matrix<double, kCommon, 1>;

inline Eigen::Vector3d to_eigen(Vec3d v) { return {v.x, v.y, v.z}; }

/// A pulse, or the first-last line of one.
struct Observation {
  std::size_t node = 0;  ///< interval [node, node + 1]
  double at = 0.0;       ///< 0..1 within it
  Eigen::Vector3d p;     ///< a return of the pulse, metres
  double angle = 0.0;    ///< recorded, sign applied, radians
  bool has_angle = false;
  bool has_pair = false;
  bool in_scan = false;
  Eigen::Vector3d e1, e2;  ///< unit, square to the first-last line
  double pair_m = 0.0;
  double share = 1.0;       ///< of an angle's weight: less where rounding errors are alike
  double angle_step = 0.0;  ///< residual that takes the angle to where it is most likely, radians
  double weight_angle = 1.0, weight_scan = 1.0, weight_pair = 1.0;
};

/// A residual with its derivatives.
struct Row {
  double value = 0.0;
  Seen by_state = Seen::Zero();
  Common by_common = Common::Zero();
};

/// Recorded angle: atan(lateral offset / height) square to the heading.
Row angle_row(const Observation& o, const Seen& x, const Common& common);

/// A plane's beams are square to its normal, a cone's make one angle with its axis.
Row scan_row(const Observation& o, const Seen& x, const Common& common, ScanModel model);

/// The first-last line misses the sensor by this, relative to what coordinates of that standard
/// deviation allow.
void pair_rows(const Observation& o, const Seen& x, double coordinate_sigma_m, Row rows[2]);

/// Values of the same alone.
double angle_value(const Observation& o, const Seen& x, const Common& common);
double scan_value(const Observation& o, const Seen& x, const Common& common, ScanModel model);
double pair_value(const Observation& o, const Seen& x, double coordinate_sigma_m);

}  // namespace cornice::flightlines
