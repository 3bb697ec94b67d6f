// SPDX-License-Identifier: GPL-3.0-or-later
// The sensor's path along one pass, from the beams that are known to pass through it.
//
// Source: D. Gatziolis, R. J. McGaughey, "Reconstructing Aircraft Trajectories from Multi-Return
// Airborne Laser-Scanning Data", Remote Sensing 11(19), 2019: first and last return of one pulse
// lie on a line through the sensor. Here their windows are one joint least-squares problem over the
// whole pass, which also takes what single returns tell: the recorded angle, and the plane or cone
// that the scanner sweeps (docs/decisions/0301-sensor-path.md).
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/vec.h"
#include "stages/flightlines/line_split.h"
#include "stages/flightlines/pulse_bins.h"

namespace cornice::flightlines {

/// Knobs of the estimate. Standard deviations are of one-sigma Gaussian priors.
struct TrajectoryOptions {
  double node_step_s = 0.25;            ///< between nodes of the path while signs and models are
                                        ///< told apart; attitude is linear between
  double fine_node_step_s = 0.1;        ///< between nodes of the path that is kept
  double speed_ms = 65.0;               ///< horizontal, survey aircraft and helicopters
  double speed_sigma_ms = 30.0;         ///< covers 30..120 m/s
  double climb_sigma_ms = 2.5;          ///< 0 +- 5 m/s at two sigma
  double velocity_walk_ms = 0.3;        ///< change of velocity in one second
  double heading_walk_deg = 0.5;        ///< change of heading in one second
  double attitude_walk_deg = 1.0;       ///< change of the scanner's axis in one second
  double attitude_sigma_deg = 6.0;      ///< of the mean: pitch and mounting tilt
  double crab_sigma_deg = 6.0;          ///< of the mean heading against the course
  double angle_offset_sigma_deg = 0.1;  ///< of the recorded angles' zero
  double angle_noise_deg = 0.01;        ///< of recorded angles before they are rounded to degrees
  double coordinate_sigma_m = 0.005;    ///< of one return across its beam, at the start
  /// Beams keep to a plane or a cone far better than its attitude between nodes is known, and that
  /// error is alike for hundreds of pulses: their scatter is not believed below this.
  double least_scan_rad = 1.5e-4;
  double fine_least_scan_rad = 3e-5;  ///< with the finer nodes
  double cone_deg = 18.0;             ///< half angle of a conical scanner, where it is known
  double cone_sigma_deg = 20.0;
  double least_pair_m = 1.0;        ///< shorter first-last distances are not used
  double least_beam_scale = 0.2;    ///< the residual scales are not believed below this factor
  std::size_t most_pulses = 60000;  ///< of each kind in one line; a long line is thinned evenly
  int iterations = 40;              ///< at most
};

/// What single returns of a scanner have in common at one time.
enum class ScanModel { kNone, kPlane, kCone };
const char* scan_model_name(ScanModel model);

struct PathNode {
  double time_s = 0.0;
  Vec3d position;  ///< projected CRS, metres
  Vec3d velocity;
  Vec3d standard_error_m;
  double heading_deg = 0.0;  ///< square to the scan: of a plane its normal, else the aircraft's
  double heading_error_deg = 0.0;
  double lean_deg = 0.0;   ///< of the scanner's plane or cone, fore positive
  double axis_side = 0.0;  ///< lean of the cone to the right, tangent
  double axis_fore = 0.0;  ///< pitch of the plane's normal, radians; lean of the cone, tangent
  bool bridged = false;    ///< no pulse within half a second
};

struct PathEstimate {
  std::vector<PathNode> nodes;
  ScanModel model = ScanModel::kNone;
  double cone_deg = 90.0;           ///< half angle; 90 for a plane
  double cone_error_deg = 0.0;      ///< its standard error
  double angle_offset_deg = 0.0;    ///< true angle minus recorded, sign applied
  double yaw_offset_deg = 0.0;      ///< of the scan plane against the heading
  double angle_residual_deg = 0.0;  ///< robust scale, recorded angle against path
  double scan_residual_deg = 0.0;   ///< robust scale, beams against plane or cone
  double pair_residual = 0.0;       ///< robust scale, first-last lines, relative to expected
  std::size_t pulses = 0;           ///< single angles used
  std::size_t pairs = 0;            ///< first-last lines used
  double cost_per_pulse = 0.0;      ///< robust, to compare two signs of one pass
  bool is_valid = false;            ///< false: too little to estimate anything
};

/// Sketches the path of one pass: nodes far apart, part of the pulses.
/// `start`: fit_track over the pass. `sign`: of the recorded angle (+1, -1), 0 where angles are all
/// zero or not to be used. `model` as chosen by estimate_path.
/// `warm`: an earlier path of the same pass and options to start from instead; may be null.
PathEstimate solve_path(const LinePass& pass, const TrackFit& start, int sign, ScanModel model,
                        const TrajectoryOptions& options = {}, const PathEstimate* warm = nullptr);

/// The same with nodes closer together and all pulses, from a sketch with that sign.
PathEstimate refine_path(const LinePass& pass, const TrackFit& start, int sign,
                         const PathEstimate& sketch, const TrajectoryOptions& options = {});

/// How the recorded angles compare with a path that was found without them.
struct AngleAgreement {
  int sign = 0;               ///< 0: the angles do not tell
  double residual_deg = 0.0;  ///< robust scale about the offset, with that sign
  double offset_deg = 0.0;    ///< median
};
AngleAgreement compare_angles(const LinePass& pass, const PathEstimate& path);

/// Chooses the scan model that explains the pulses best, first-last lines no worse than without
/// one, and sketches with it.
PathEstimate estimate_path(const LinePass& pass, const TrackFit& start, int sign,
                           const TrajectoryOptions& options = {});

}  // namespace cornice::flightlines
