// SPDX-License-Identifier: GPL-3.0-or-later
// A simulated survey with its truth, made by the project's own executables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/points/flight_line.h"
#include "core/points/point_cloud.h"

namespace cornice::bench {

/// What to fly over.
struct SurveyPlan {
  std::string scene;           ///< name of a scene file: "alp", "cliff"
  std::string scanner;         ///< "oscillating", "polygon", "palmer"
  bool whole_degrees = false;  ///< recorded scan angles in whole degrees, as in formats 0-5
  int tile_m = 200;
  double density = 20.0;
  double noise_m = 0.03;
  std::uint64_t seed = 1;
  bool true_lines = false;  ///< take the true trajectory instead of the estimate

  /// "cliff palmer whole".
  std::string name() const;
};

/// One tile of it. truth and overhang have one entry per point.
struct Survey {
  PointCloud points;
  std::filesystem::path tile;
  FlightLines lines;
  std::vector<Vec3f> truth;  ///< unit normals out of the ground
};

/// Runs cornice-simulate and cornice-flightlines from the folder `programs` and reads what they
/// wrote below `folder`. The scene lies in one of the folders `scenes`. Throws RunError where a
/// program fails.
Survey fly(const SurveyPlan& plan, const std::filesystem::path& programs,
           const std::vector<std::filesystem::path>& scenes, const std::filesystem::path& folder,
           int threads);

}  // namespace cornice::bench
