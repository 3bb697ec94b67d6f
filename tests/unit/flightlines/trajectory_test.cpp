// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <tuple>

#include "tests/unit/flightlines/flown_line.h"

namespace cornice::flightlines::test {
namespace {

struct Errors {
  double horizontal_rms = 0.0, vertical_rms = 0.0, rms = 0.0;
};

Errors errors_of(const PathEstimate& path, const Flight& flight) {
  Errors e;
  for (const PathNode& node : path.nodes) {
    const Vec3d d = node.position - pose_at(flight, node.time_s).position;
    e.horizontal_rms += d.x * d.x + d.y * d.y;
    e.vertical_rms += d.z * d.z;
  }
  const auto n = static_cast<double>(path.nodes.size());
  e.rms = std::sqrt((e.horizontal_rms + e.vertical_rms) / n);
  e.horizontal_rms = std::sqrt(e.horizontal_rms / n);
  e.vertical_rms = std::sqrt(e.vertical_rms / n);
  return e;
}

PathEstimate path_of(const Flight& flight) {
  TileBinner binner;
  binner.add(fly(flight));
  BinSet set = binner.finish("test");
  const SplitResult split = split_lines(set);
  EXPECT_EQ(split.passes.size(), 1u);
  const LinePass& pass = split.passes[0];
  const TrackFit track = fit_track(pass.bins, 0, pass.bins.size());
  const PathEstimate path = estimate_path(pass, track, flight.angle_sign);
  const Errors e = errors_of(path, flight);
  if (std::getenv("CORNICE_SHOW") != nullptr)
    std::cout << "model " << scan_model_name(path.model) << " cone " << path.cone_deg << " angle "
              << path.angle_residual_deg << " scan " << path.scan_residual_deg << " pair "
              << path.pair_residual << " offset " << path.angle_offset_deg << " hor "
              << e.horizontal_rms << " ver " << e.vertical_rms << " se "
              << path.nodes[path.nodes.size() / 2].standard_error_m.x << " "
              << path.nodes[path.nodes.size() / 2].standard_error_m.y << " "
              << path.nodes[path.nodes.size() / 2].standard_error_m.z << " heading "
              << path.nodes[path.nodes.size() / 2].heading_deg << "\n";
  return path;
}

using Setting = std::tuple<Pattern, bool, double>;

class SensorPath : public testing::TestWithParam<Setting> {};

TEST_P(SensorPath, IsFoundWithinTheTargetForEachPatternAndAngleResolution) {
  Flight flight;
  std::tie(flight.pattern, flight.whole_degrees, flight.tree_share) = GetParam();
  const PathEstimate path = path_of(flight);
  ASSERT_TRUE(path.is_valid);
  EXPECT_LT(errors_of(path, flight).rms, flight.whole_degrees ? 5.0 : 1.0);
}

INSTANTIATE_TEST_SUITE_P(Settings, SensorPath,
                         testing::Combine(testing::Values(Pattern::kOscillating, Pattern::kPolygon,
                                                          Pattern::kPalmer),
                                          testing::Bool(), testing::Values(0.0, 0.2)));

}  // namespace
}  // namespace cornice::flightlines::test
