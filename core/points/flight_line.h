// SPDX-License-Identifier: GPL-3.0-or-later
// Flight lines and the sensor's path along them: written by the flightlines stage, read by normals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice {

/// What the beams of a line are known from; each step down is worse than the one before.
enum class BeamSource : std::uint8_t { kTrajectory, kAngles, kVertical };

/// Position of the sensor at one time.
struct TrajectoryNode {
  double gps_time_s = 0.0;
  Vec3d position;          ///< projected CRS, metres
  Vec3f standard_error_m;  ///< of position, per axis
  bool bridged = false;    ///< interpolated over a gap without pulses
};

/// One pass of the aircraft.
struct FlightLine {
  std::uint32_t id = 0;  ///< consecutive from 1, by first time
  std::uint16_t point_source_id = 0;
  std::uint8_t scanner_channel = 0;
  double first_time_s = 0.0;
  double last_time_s = 0.0;
  double along_azimuth_deg = 0.0;   ///< heading, clockwise from grid north, 0..360
  double across_azimuth_deg = 0.0;  ///< towards positive TRUE across-track angle (right), 0..360
  double across_standard_error_deg = 0.0;
  int scan_angle_sign = 0;  ///< +1: recorded positive angles lie to the right of flight; -1: to the
                            ///< left; 0: not known
  BeamSource beam_source = BeamSource::kVertical;
  std::string beam_reason;            ///< why it is no better; empty for kTrajectory
  std::vector<TrajectoryNode> nodes;  ///< in time order; empty unless kTrajectory
};

/// All lines of a survey.
struct FlightLines {
  std::string crs_text;
  std::vector<FlightLine> lines;

  /// Index of the line a point belongs to, nothing where none covers its time (to `slack_s`).
  /// Constant-time after the first call would need state; it is a binary search over lines.
  std::optional<std::size_t> find(std::uint16_t point_source_id, std::uint8_t channel,
                                  double gps_time_s, double slack_s = 0.5) const;
};

/// Sensor position at a time by interpolation between nodes (extrapolated linearly by at most one
/// node spacing); nothing where the line has no trajectory there.
std::optional<Vec3d> sensor_at(const FlightLine& line, double gps_time_s);

/// Unit beam from sensor to point: from the trajectory, else from azimuth and recorded scan angle
/// (degrees, sign as recorded), else straight down, by line.beam_source.
Vec3d beam_at(const FlightLine& line, double gps_time_s, Vec3d point, double scan_angle_deg);

}  // namespace cornice
