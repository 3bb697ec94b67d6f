// SPDX-License-Identifier: GPL-3.0-or-later
// Small surveys over scenes that can be worked out by hand.
#pragma once

#include <string>
#include <vector>

#include "property/simulate_survey/test_scenes.h"
#include "stages/simulate/survey.h"

namespace cornice::test {

/// 100 m x 100 m in two by two tiles, 4 points/m2.
simulate::SurveyOptions small_survey();

/// A flat scene with what a test asks for, around the tiles of `options`.
PlaneScene scene_for(const simulate::SurveyOptions& options);

/// All points of a survey in the order they are measured.
std::vector<simulate::SurveyPoint> points_of(const simulate::Survey& survey);

/// Position of the sensor when a point without defects of time was measured.
Vec3d sensor_of(const simulate::Survey& survey, const simulate::SurveyPoint& point);

}  // namespace cornice::test
