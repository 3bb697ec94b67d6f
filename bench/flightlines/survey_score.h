// SPDX-License-Identifier: GPL-3.0-or-later
// Simulated surveys in memory, the lines found in them, and how far they are from the truth. For
// bench-flightlines and for the property tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/points/point_cloud.h"
#include "stages/flightlines/survey_lines.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/survey.h"

namespace cornice::bench {

/// Points of a survey, tile by tile, and the truth that goes with them.
struct FlownSurvey {
  std::unique_ptr<simulate::Survey> survey;
  std::vector<PointCloud> tiles;
  std::vector<simulate::LineTally> tallies;
  std::size_t points() const;
};

/// The scene of a survey, just as large as it needs.
std::unique_ptr<simulate::Scene> build_scene(const simulate::SurveyOptions& options, int threads);

/// Flies a survey without writing anything.
FlownSurvey fly_in_memory(const simulate::SurveyOptions& options, const simulate::Scene& scene,
                          int threads);

/// Lines of tiles in memory; `seconds`: what it took.
flightlines::SurveyLines find_lines(const std::vector<PointCloud>& tiles, int threads,
                                    double& seconds);

/// How one line came out.
struct LineScore {
  std::uint32_t id = 0;           ///< of the line found
  double across_error_deg = 0.0;  ///< found minus true
  double square_sum = 0.0;        ///< of its nodes' position errors, m2
  double vertical_square_sum = 0.0;
  std::size_t nodes = 0;
};

struct Score {
  double azimuth_error_deg = 0.0;  ///< largest
  double crab_error_deg = 0.0;     ///< largest, of the angle between the azimuths less 90
  double square_sum = 0.0;         ///< of all nodes' position errors, m2
  double horizontal_sum = 0.0;
  std::size_t nodes = 0;
  int split_errors = 0;  ///< true lines not found whole and once, and lines that are none
  int sign_errors = 0;
  int without_path = 0;
  int lines = 0;
  std::vector<LineScore> each;  ///< of this survey alone: add() leaves it

  void add(const Score& other);
  double per_node(double sum) const {
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, nodes)));
  }
  double rms_m() const { return per_node(square_sum); }
  double horizontal_m() const { return per_node(horizontal_sum); }
  double vertical_m() const { return per_node(square_sum - horizontal_sum); }
};

/// Each true line with points must be found once, over the same time.
Score score_lines(const FlownSurvey& flown, const flightlines::SurveyLines& found);

}  // namespace cornice::bench
