// SPDX-License-Identifier: GPL-3.0-or-later
// The beam of every point, from the flight lines.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/points/flight_line.h"
#include "core/points/point_cloud.h"
#include "stages/normals/orient.h"

namespace cornice::normals {

/// Beams of points, and where they come from. Nothing is silent: every step down is counted.
struct PointBeams {
  Beams beams;
  std::vector<std::uint16_t> line_id;  ///< N; 0 where no line covers the point's time
  std::array<std::size_t, 3>
      by_source{};  ///< points by BeamSource; those without a line as vertical
  std::size_t without_line = 0;
};

/// Beams no better than `best`: kTrajectory takes what each line has, kAngles the recorded scan
/// angle and the azimuth across the line, kVertical straight down. Uses the points' gps_time_s,
/// scan_angle_deg, point_source_id, scanner_channel and user_data; an empty array counts as zeros.
/// Lines with ids beyond 65,535 throw InputError: the output has 16 bits for them.
PointBeams find_beams(const PointCloud& points, const FlightLines& lines, BeamSource best,
                      int threads);

}  // namespace cornice::normals
