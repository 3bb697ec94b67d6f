// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/line_estimate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "stages/flightlines/survey_lines.h"
#include "tests/unit/flightlines/flown_line.h"

namespace cornice::flightlines::test {
namespace {

SurveyLines lines_of(const std::vector<PointCloud>& tiles) {
  BinSet bins;
  SheetPairs pairs;
  for (const PointCloud& tile : tiles) {
    TileBinner binner;
    TileOverlap overlap(tile.origin, 1.0);
    binner.add(tile);
    overlap.add(tile);
    merge_bins(bins, binner.finish("test"), {});
    merge_pairs(pairs, overlap.finish());
  }
  SurveyLines survey;
  estimate_survey(std::move(bins), pairs, {}, survey);
  return survey;
}

double off(double a_deg, double b_deg) { return std::abs(std::remainder(a_deg - b_deg, 360.0)); }

TEST(LineEstimate, FindsAzimuthsHeightSpeedAndAngles) {
  Flight flight;
  flight.tree_share = 0.1;
  const SurveyLines survey = lines_of({fly(flight)});
  ASSERT_EQ(survey.lines.size(), 1u);
  const LineEstimate& e = survey.lines[0];
  EXPECT_EQ(e.line.beam_source, BeamSource::kTrajectory);
  EXPECT_LT(off(e.line.along_azimuth_deg, 30.0), 0.3);
  EXPECT_LT(off(e.line.across_azimuth_deg, 122.0), 0.1);
  EXPECT_NEAR(e.perpendicular_deg, 2.0, 0.3);
  EXPECT_NEAR(e.speed_ms, 60.0, 1.0);
  EXPECT_NEAR(e.height_m, 1200.0, 60.0);
  EXPECT_NEAR(e.pulse_rate_hz, 4000.0, 40.0);
  EXPECT_EQ(e.line.scan_angle_sign, 1);
  EXPECT_NEAR(e.min_angle_deg, -21.0, 1.5);
  EXPECT_EQ(e.looks, 1);
  EXPECT_EQ(e.points, fly(flight).size());
}

TEST(LineEstimate, FindsAReversedAngleSignLineByLine) {
  Flight right, left;
  left.angle_sign = -1;
  left.start_time_s = 5000.0;
  left.azimuth_deg = 210.0;
  left.id = 8;
  for (const double trees : {0.0, 0.2}) {
    right.tree_share = left.tree_share = trees;
    const SurveyLines survey = lines_of({fly(right), fly(left)});
    ASSERT_EQ(survey.lines.size(), 2u);
    EXPECT_EQ(survey.lines[0].line.scan_angle_sign, 1);
    EXPECT_EQ(survey.lines[1].line.scan_angle_sign, -1);
    EXPECT_LT(off(survey.lines[0].line.across_azimuth_deg, 122.0), 0.1);
    EXPECT_LT(off(survey.lines[1].line.across_azimuth_deg, 302.0), 0.1);
  }
}

TEST(LineEstimate, SeesTheLeanOfATiltedScannerAndTheTwoLooksOfACone) {
  Flight tilted;
  tilted.tilt_deg = 7.0;
  tilted.tree_share = 0.2;
  EXPECT_NEAR(lines_of({fly(tilted)}).lines[0].lean_deg, 7.0, 0.5);
  Flight cone;
  cone.pattern = Pattern::kPalmer;
  const LineEstimate e = lines_of({fly(cone)}).lines[0];
  EXPECT_EQ(e.looks, 2);
  EXPECT_EQ(e.scan_model, ScanModel::kCone);
  EXPECT_NEAR(e.cone_deg, 20.0, 0.05);
}

TEST(LineEstimate, WorksFromPairsAloneWhereAllAnglesAreZero) {
  Flight flight;
  flight.tree_share = 0.3;
  PointCloud points = fly(flight);
  std::fill(points.scan_angle_deg.begin(), points.scan_angle_deg.end(), 0.0f);
  const LineEstimate e = lines_of({points}).lines[0];
  EXPECT_EQ(e.line.beam_source, BeamSource::kTrajectory);
  EXPECT_EQ(e.line.scan_angle_sign, 0);
  EXPECT_NEAR(e.height_m, 1200.0, 60.0);
}

TEST(LineEstimate, HasVerticalBeamsAndSaysWhyWhereAnglesAreZeroAndNoPulseHasTwoReturns) {
  Flight flight;
  flight.duration_s = 4.0;
  PointCloud points = fly(flight);
  std::fill(points.scan_angle_deg.begin(), points.scan_angle_deg.end(), 0.0f);
  const LineEstimate e = lines_of({points}).lines[0];
  EXPECT_EQ(e.line.beam_source, BeamSource::kVertical);
  EXPECT_NE(e.line.beam_reason.find("angles are 0"), std::string::npos);
}

TEST(LineEstimate, UsesTheDirectionOfGrowingAnglesWhereThereIsNoTime) {
  Flight flight;
  flight.angle_sign = -1;
  flight.unrest = 0.2;
  PointCloud points = fly(flight);
  std::fill(points.gps_time_s.begin(), points.gps_time_s.end(), 0.0);
  const SurveyLines survey = lines_of({points});
  ASSERT_EQ(survey.lines.size(), 1u);
  const FlightLine& line = survey.lines[0].line;
  EXPECT_FALSE(line.has_time);
  ASSERT_EQ(line.beam_source, BeamSource::kAngles);
  EXPECT_NE(line.beam_reason.find("no usable GPS time"), std::string::npos);
  // Recorded positive angles lie to the left of flight here.
  EXPECT_LT(off(line.across_azimuth_deg, 122.0 + 180.0), 4.0);
  const Vec3d beam = beam_at(line, 0.0, {}, 20.0);
  const Vec3d left{-std::cos(0.5236), std::sin(0.5236), 0.0};
  EXPECT_GT(dot(beam, left), 0.3);
}

TEST(LineEstimate, OfThreePointsIsALineWithAReason) {
  Flight flight;
  flight.duration_s = 0.00075;
  PointCloud points = fly(flight);
  ASSERT_EQ(points.size(), 3u);
  const SurveyLines survey = lines_of({points});
  ASSERT_EQ(survey.lines.size(), 1u);
  EXPECT_EQ(survey.lines[0].points, 3u);
  EXPECT_NE(survey.lines[0].line.beam_source, BeamSource::kTrajectory);
  EXPECT_FALSE(survey.lines[0].line.beam_reason.empty());
}

TEST(LineEstimate, PathsOfOneLineFromTwoTilesAgreeWhereTheyMeet) {
  Flight flight;
  flight.tree_share = 0.3;
  const double border = flight.start.y + 520.0;
  const SurveyLines south = lines_of({fly(flight, [&](Vec3d p) { return p.y < border; })});
  const SurveyLines north = lines_of({fly(flight, [&](Vec3d p) { return p.y >= border; })});
  const FlightLine& a = south.lines.at(0).line;
  const FlightLine& b = north.lines.at(0).line;
  const double time = 0.5 * (a.last_time_s + b.first_time_s);
  const auto sa = sensor_at(a, time), sb = sensor_at(b, time);
  ASSERT_TRUE(sa && sb);
  EXPECT_LT(norm(*sa - *sb), 2.0);
}

TEST(LineEstimate, BridgesAGapAndMarksItsNodes) {
  Flight flight;
  flight.duration_s = 40.0;
  const double a = flight.azimuth_deg * 3.14159265358979 / 180.0;
  const PointCloud points = fly(flight, [&](Vec3d p) {
    const double along =
        (p.x - flight.start.x) * std::sin(a) + (p.y - flight.start.y) * std::cos(a);
    return along < 900.0 || along > 1500.0;
  });
  const LineEstimate e = lines_of({points}).lines.at(0);
  ASSERT_EQ(e.line.beam_source, BeamSource::kTrajectory);
  EXPECT_NEAR(e.bridged_s, 9.0, 2.5);
  const auto middle = sensor_at(e.line, 1020.0);
  ASSERT_TRUE(middle);
  EXPECT_LT(norm(*middle - pose_at(flight, 1020.0).position), 10.0);
  std::size_t bridged = 0;
  for (const TrajectoryNode& node : e.line.nodes) bridged += node.bridged;
  EXPECT_GT(bridged, 8u);
}

TEST(LineEstimate, DoesNotTakeAnglesThatLeaveOutTheRoll) {
  Flight flight;
  flight.tree_share = 0.3;
  PointCloud points = fly(flight);
  for (std::size_t i = 0; i < points.size(); ++i)
    points.scan_angle_deg[i] += static_cast<float>(2.0 * std::sin(points.gps_time_s[i] / 1.1));
  const LineEstimate e = lines_of({points}).lines.at(0);
  EXPECT_EQ(e.line.beam_source, BeamSource::kTrajectory);
  EXPECT_EQ(e.method.find("angles"), std::string::npos);
  EXPECT_EQ(e.line.scan_angle_sign, 1);
  const auto middle = sensor_at(e.line, 1010.0);
  ASSERT_TRUE(middle);
  EXPECT_LT(norm(*middle - pose_at(flight, 1010.0).position), 2.0);
}

TEST(LineEstimate, SurvivesOutliersAndBrokenReturnNumbers) {
  Flight flight;
  flight.tree_share = 0.2;
  PointCloud points = fly(flight);
  for (std::size_t i = 0; i < points.size(); i += 40) points.positions[i].z += 150.0f;
  for (std::size_t i = 5; i < points.size(); i += 30) points.return_number[i] = 1;
  const LineEstimate e = lines_of({points}).lines.at(0);
  ASSERT_EQ(e.line.beam_source, BeamSource::kTrajectory);
  const auto middle = sensor_at(e.line, 1010.0);
  EXPECT_LT(norm(*middle - pose_at(flight, 1010.0).position), 1.0);
}

TEST(LineEstimate, IsTheSameWithOneAndTwoThreads) {
  Flight flight;
  flight.duration_s = 6.0;
  Flight other = flight;
  other.id = 9;
  other.start_time_s = 9000.0;
  TileBinner binner;
  binner.add(fly(flight));
  binner.add(fly(other));
  const BinSet bins = binner.finish("test");
  SurveyLines found[2];
  for (const int threads : {1, 2}) {
    SurveyOptions options;
    options.threads = threads;
    estimate_survey(BinSet(bins), {}, options, found[threads - 1]);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& a = found[0].lines[i].line.nodes;
    const auto& b = found[1].lines[i].line.nodes;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].position, b[k].position);
  }
}

TEST(LineEstimate, RejectsAPathThatNoAircraftFlies) {
  Flight flight;
  flight.duration_s = 6.0;
  flight.height_m = 60.0;  // over a ground that undulates by 60 m
  flight.relief_m = 5.0;
  const LineEstimate e = lines_of({fly(flight)}).lines.at(0);
  EXPECT_NE(e.line.beam_source, BeamSource::kTrajectory);
  EXPECT_NE(e.line.beam_reason.find("height above ground "), std::string::npos)
      << e.line.beam_reason;
  EXPECT_NE(e.line.beam_reason.find(" m, allowed 80 to 6000"), std::string::npos)
      << e.line.beam_reason;
  EXPECT_TRUE(std::any_of(e.checks.begin(), e.checks.end(),
                          [](const AcceptCheck& c) { return !c.passed; }));
}

TEST(Overlap, FindsTheHeightMismatchOfTwoLines) {
  Flight first, second;
  first.relief_m = second.relief_m = 2.0;
  first.pulses_per_s = second.pulses_per_s = 20000.0;
  first.duration_s = second.duration_s = 6.0;
  first.half_view_deg = second.half_view_deg = 5.0;
  second.start_time_s = 4000.0;
  second.id = 8;
  PointCloud raised = fly(second);
  for (Vec3f& p : raised.positions) p.z += 0.12f;
  PointCloud all = fly(first);
  all.append(raised);
  const SurveyLines survey = lines_of({all});
  ASSERT_EQ(survey.overlaps.size(), 1u);
  EXPECT_EQ(survey.overlaps[0].first_line, 1u);
  EXPECT_NEAR(survey.overlaps[0].median_dz_m, 0.12, 0.015);
  EXPECT_GT(survey.overlaps[0].cells, 100u);
}

}  // namespace
}  // namespace cornice::flightlines::test
