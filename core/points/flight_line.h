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
  bool has_time = true;               ///< false: the points carry no usable GPS time; the line then
                                      ///< stands for every point of its id and channel
  bool channel_in_user_data = false;  ///< scanner_channel holds the points' user data instead
  double first_time_s = 0.0;  ///< seconds as stored; a line that crosses the end of a GPS week goes
                              ///< on above 604800
  double last_time_s = 0.0;
  double along_azimuth_deg = 0.0;  ///< heading, clockwise from grid north, 0..360
  /// Towards positive TRUE across-track angle (right of flight), 0..360. Where the direction of
  /// flight is not known: towards recorded positive angles, scan_angle_sign being +1.
  double across_azimuth_deg = 0.0;
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

  /// Index of the line a point belongs to, nothing where none covers its time (to `slack_s`); where
  /// two do, the one whose span is nearer. Looks at every line: for many points use LineFinder.
  std::optional<std::size_t> find(std::uint16_t point_source_id, std::uint8_t channel,
                                  double gps_time_s, double slack_s = 0.5) const;
};

/// FlightLines::find for many points: lines grouped by id and channel, the last answer tried first.
/// Thread contract: one object per thread. `lines` must outlive it and keep its lines in place.
class LineFinder {
 public:
  explicit LineFinder(const FlightLines& lines, double slack_s = 0.5);
  /// `user_data` counts only for lines whose channel is told by it.
  std::optional<std::size_t> find(std::uint16_t point_source_id, std::uint8_t channel,
                                  double gps_time_s, std::uint8_t user_data = 0);

 private:
  const FlightLines& lines_;
  double slack_s_;
  std::vector<std::vector<std::uint32_t>> groups_;  ///< lines of one id and channel, in file order
  std::vector<std::uint32_t> group_of_id_;          ///< by id: first group; kNoGroup where none
  std::vector<std::uint32_t> next_group_;           ///< the id's next channel
  std::optional<std::size_t> last_;
};

/// A stored time on the line's own clock: 604800 s later where the line crosses the end of a GPS
/// week before that time.
double time_on_line(const FlightLine& line, double gps_time_s);

/// Sensor position at a time by interpolation between nodes (extrapolated linearly by at most one
/// node spacing); nothing where the line has no trajectory there.
std::optional<Vec3d> sensor_at(const FlightLine& line, double gps_time_s);

/// Unit beam from sensor to point: from the trajectory, else from azimuth and recorded scan angle
/// (degrees, sign as recorded), else straight down, by line.beam_source and by whether the
/// trajectory covers the time. `used` tells which it was.
Vec3d beam_at(const FlightLine& line, double gps_time_s, Vec3d point, double scan_angle_deg,
              BeamSource* used = nullptr);

/// "trajectory", "angles" or "vertical".
const char* beam_source_name(BeamSource source);

}  // namespace cornice
