// SPDX-License-Identifier: GPL-3.0-or-later
// The flight: parallel passes with turns between them, and where the sensor is at every moment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "stages/simulate/scanner.h"

namespace cornice::simulate {

/// How the survey is flown.
struct FlightOptions {
  double azimuth_deg =
      20.0;                  ///< of the first pass, clockwise from grid north; the next one returns
  double height_m = 1200.0;  ///< above the mean ground of the survey; all passes fly level
  double speed_ms = 60.0;    ///< over ground, 10..200
  /// Share of a swath that its neighbour covers as well, on the highest ground (lower ground has
  /// more). 0..0.8.
  double overlap = 0.3;
  bool cross_line = false;  ///< one more pass through the centre, across the others
  /// Scale of the aircraft's unrest: 0 flies like a ruler, 1 like a survey aircraft in calm air.
  double motion = 1.0;
  double turn_s = 90.0;         ///< from the end of a pass to the start of the next
  double start_time_s = 0.0;    ///< adjusted standard GPS time of the first pass
  double node_step_s = 0.01;    ///< between the nodes of the trajectory
  double survey_break_s = 0.0;  ///< more time before the second half of the passes, which then
                                ///< counts as another survey
};

/// Heights of the ground under the survey.
struct GroundRange {
  double lowest_m = 0.0;
  double mean_m = 0.0;
  double highest_m = 0.0;
};

/// One straight pass.
struct Pass {
  bool is_cross_line = false;
  int survey = 0;  ///< 1 for the passes after FlightOptions::survey_break_s
  double azimuth_deg = 0.0;
  double first_time_s = 0.0;
  double last_time_s = 0.0;
  Vec3d start;  ///< nominal
  Vec3d end;
  double crab_deg = 0.0;  ///< heading minus azimuth, against the wind
  std::size_t first_node = 0;
  std::size_t node_count = 0;
};

/// The sensor at one time. Angles as aircraft count them: right wing down, nose up and clockwise
/// are positive.
struct TrajectoryPose {
  double gps_time_s = 0.0;
  int pass = -1;  ///< -1 in turns
  Vec3d position;
  double roll_deg = 0.0;
  double pitch_deg = 0.0;
  double heading_deg = 0.0;
};

/// Position and axes of the sensor in the survey's CRS (x east, y north, z up).
struct SensorFrame {
  Vec3d position;
  Vec3d forward;  ///< to the nose
  Vec3d right;    ///< to the right wing
  Vec3d down;

  Vec3d to_world(Vec3d body) const { return body.x * forward + body.y * right + body.z * down; }
};

/// Angle from nadir of a beam in the vertical plane across the heading, positive to the right of
/// flight, in degrees: what LAS calls the scan angle, roll included.
double across_track_angle_deg(const SensorFrame& frame, Vec3d beam);

/// A flight, known at every moment: linear between nodes, so that whoever interpolates the written
/// trajectory gets the very positions that the points were measured from.
/// Thread contract: const members may be called from many threads.
class Trajectory {
 public:
  /// Plans passes whose swaths cover `extent`. Throws UsageError naming the option where heights
  /// are impossible or a value is out of its range.
  static Trajectory plan(const FlightOptions& flight, const ScannerOptions& scanner,
                         const Box2d& extent, const GroundRange& ground, std::uint64_t seed);

  const std::vector<Pass>& passes() const { return passes_; }
  /// Poses of all passes and turns, in time order. Turns have fewer.
  const std::vector<TrajectoryPose>& poses() const { return poses_; }
  double altitude_m() const { return altitude_m_; }
  double pass_spacing_m() const { return pass_spacing_m_; }
  /// Width of a swath on ground of a height.
  double swath_m(double ground_m) const;
  /// Seconds of all passes together.
  double measuring_s() const;

  /// Frame at a time within the pass.
  SensorFrame at(std::size_t pass, double gps_time_s) const;

 private:
  Trajectory() = default;
  void place_passes(const FlightOptions& flight, const ScannerOptions& scanner, const Box2d& extent,
                    const GroundRange& ground, std::uint64_t seed);
  void fill_poses(const FlightOptions& flight, std::uint64_t seed);

  double altitude_m_ = 0.0;
  double pass_spacing_m_ = 0.0;
  double tan_half_view_ = 0.0;
  double node_step_s_ = 0.01;
  std::vector<Pass> passes_;
  std::vector<TrajectoryPose> poses_;
  std::vector<SensorFrame> frames_;  ///< one per pose
};

}  // namespace cornice::simulate
