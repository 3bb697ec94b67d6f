// SPDX-License-Identifier: GPL-3.0-or-later
// A small flight for tests: one pass of an unsteady aircraft over undulating ground, three scanner
// patterns, independent of the survey simulator.
#pragma once

#include <cstdint>
#include <functional>

#include "core/points/point_cloud.h"

namespace cornice::flightlines::test {

enum class Pattern { kOscillating, kPolygon, kPalmer };

struct Flight {
  Pattern pattern = Pattern::kPolygon;
  double azimuth_deg = 30.0;
  double crab_deg = 2.0;
  double speed_ms = 60.0;
  double start_time_s = 1000.0;
  double duration_s = 20.0;
  double height_m = 1200.0;  ///< above zero
  Vec3d start{2600000.0, 1200000.0, 0.0};
  double half_view_deg = 20.0;
  double tilt_deg = 0.0;  ///< of the scanner, fore
  double pulses_per_s = 4000.0;
  double scans_per_s = 40.0;
  double relief_m = 60.0;   ///< amplitude of the ground
  double tree_share = 0.0;  ///< of pulses with two returns
  double unrest = 1.0;      ///< 0: flies like a ruler
  bool whole_degrees = false;
  int angle_sign = 1;
  std::uint16_t id = 7;
  std::uint8_t channel = 0;
  std::uint8_t user_data = 0;
  std::uint64_t seed = 1;
};

/// Sensor and heading at a time of the flight.
struct Pose {
  Vec3d position;
  double roll_deg, pitch_deg, heading_deg;
};
Pose pose_at(const Flight& flight, double time_s);

/// The points of a pass, in time order; coordinates on a 1 cm grid. `keep` cuts a window.
PointCloud fly(
    const Flight& flight, const std::function<bool(Vec3d)>& keep = [](Vec3d) { return true; });

}  // namespace cornice::flightlines::test
