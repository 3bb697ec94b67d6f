// SPDX-License-Identifier: GPL-3.0-or-later
// Everything that is said of one flight line, and whether its path is to be trusted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/points/flight_line.h"
#include "stages/flightlines/line_split.h"
#include "stages/flightlines/trajectory.h"

namespace cornice::flightlines {

/// Bounds of the accept test; a path outside any of them is not used for beams.
struct AcceptOptions {
  double least_height_m = 80.0;  ///< of the sensor above the ground
  double most_height_m = 6000.0;
  double least_speed_ms = 15.0;
  double most_speed_ms = 150.0;
  double most_error_share = 0.03;  ///< horizontal standard error / height: 1.7 degrees of beam
  double most_height_share = 0.2;  ///< standard error of the height / height
  double clip_s = 2.0;  ///< shorter lines with whole degrees have their height error times the next
  double clip_error_factor = 50.0;       ///< met on the worst real clips
  double most_angle_residual_deg = 0.6;  ///< robust scale against the recorded angle
  double most_angle_offset_deg = 1.0;
  std::size_t enough_pairs = 200;    ///< make a path without the angles' help
  double most_pair_residual = 10.0;  ///< relative to what the coordinates allow
};

/// One check of the accept test, as printed.
struct AcceptCheck {
  std::string name;  ///< "height_m"
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
  bool passed = false;
};

struct LineEstimate {
  FlightLine line;
  std::string method;  ///< "pairs+angles+plane", ...; empty without a path
  ScanModel scan_model = ScanModel::kNone;
  std::uint64_t points = 0;
  std::size_t pulses_used = 0;
  std::size_t pairs_used = 0;
  double along_standard_error_deg = 180.0;
  double perpendicular_deg = 0.0;  ///< across minus along azimuth minus 90; crab of the aircraft
  double height_m = 0.0;           ///< flying height above the ground met
  double speed_ms = 0.0;
  double min_angle_deg = 0.0;  ///< as recorded
  double max_angle_deg = 0.0;
  double angle_step_deg = 0.0;  ///< 1 where all recorded angles are whole degrees, else 0
  double pulse_rate_hz = 0.0;   ///< 0 where not known
  double lean_deg = 0.0;        ///< of the beams, fore positive; of a cone: of its axis
  double cone_deg = 0.0;        ///< half angle of a conical scanner, else 0
  double cone_error_deg = 0.0;  ///< its standard error, from this line alone
  int looks = 1;                ///< 2: the ground is seen fore and aft
  double angle_offset_deg = 0.0;
  double angle_residual_deg = 0.0;
  double scan_residual_deg = 0.0;
  double pair_residual = 0.0;
  double position_error_m = 0.0;  ///< median standard error of the nodes, horizontal
  double height_error_m = 0.0;
  double bridged_s = 0.0;  ///< time of the path without pulses
  std::string sign_from;   ///< "pairs and angles", "track", "" where not known
  std::vector<AcceptCheck> checks;
  std::vector<std::string> remarks;  ///< each oddity, one sentence
};

/// Estimates one pass. Coordinates are metres.
LineEstimate estimate_line(const LinePass& pass, const TrajectoryOptions& options = {},
                           const AcceptOptions& accept = {});

/// Half angle of a cone that lines of a survey share.
struct SharedCone {
  double cone_deg = 0.0;
  double sigma_deg = 0.0;
  std::size_t lines = 0;  ///< that know it well; 0: none do, or they differ
};
SharedCone shared_cone(const std::vector<LineEstimate>& lines);

/// True for lines that know their place so badly that the cone of the others helps them, and do not
/// contradict it.
bool needs_cone(const LineEstimate& line, const SharedCone& cone);

/// Lines whose sign no pulse of theirs tells take the sign that all other lines of the survey
/// share, and say so; returns how many.
std::size_t settle_unknown_signs(std::vector<LineEstimate>& lines);

}  // namespace cornice::flightlines
