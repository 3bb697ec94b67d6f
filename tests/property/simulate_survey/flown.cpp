// SPDX-License-Identifier: GPL-3.0-or-later
#include "property/simulate_survey/flown.h"

namespace cornice::test {

using namespace simulate;

SurveyOptions small_survey() {
  SurveyOptions options;
  options.tiles = "2x2";
  options.tile_m = 50.0;
  options.density = 4.0;
  return options;
}

PlaneScene scene_for(const SurveyOptions& options) {
  PlaneScene scene;
  scene.extent = scene_extent(tile_grid(options));
  return scene;
}

std::vector<SurveyPoint> points_of(const Survey& survey) {
  std::vector<SurveyPoint> points;
  for (std::size_t pass = 0; pass < survey.trajectory.passes().size(); ++pass) {
    const BlockPoints block =
        simulate_block(survey.setup, {pass, 0, pulses_of_pass(survey.setup, pass)});
    points.insert(points.end(), block.points.begin(), block.points.end());
  }
  return points;
}

Vec3d sensor_of(const Survey& survey, const SurveyPoint& point) {
  const SurveyLine& line = survey.setup.lines[point.line - 1u];
  return survey.trajectory.at(static_cast<std::size_t>(line.pass), point.gps_time_s).position;
}

}  // namespace cornice::test
