// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "core/base/error.h"

namespace cornice::simulate {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
const Box2d kExtent{2746000.0, 1234000.0, 2747000.0, 1235000.0};
const GroundRange kFlat{500.0, 500.0, 500.0};

FlightOptions flight() {
  FlightOptions options;
  options.start_time_s = 3e8;
  return options;
}

double wrapped(double degrees) { return degrees - 360.0 * std::round(degrees / 360.0); }

TEST(Trajectory, NeighbouringPassesRunOppositeWaysAtTheSpacingOfTheOverlap) {
  FlightOptions options = flight();
  options.overlap = 0.4;
  const Trajectory t = Trajectory::plan(options, {}, kExtent, kFlat, 1);
  const double swath = 2.0 * 1200.0 * std::tan(20.0 * kRadians);
  EXPECT_NEAR(t.swath_m(500.0), swath, 1e-9);
  EXPECT_NEAR(t.pass_spacing_m(), 0.6 * swath, 1e-9);
  ASSERT_GE(t.passes().size(), 2u);
  const Vec3d across{std::cos(20.0 * kRadians), -std::sin(20.0 * kRadians), 0.0};
  for (std::size_t i = 1; i < t.passes().size(); ++i) {
    const Pass &a = t.passes()[i - 1], &b = t.passes()[i];
    EXPECT_NEAR(std::abs(wrapped(a.azimuth_deg - b.azimuth_deg)), 180.0, 1e-9);
    EXPECT_NEAR(dot(b.start - a.start, across), 0.6 * swath, 1e-6);
  }
}

TEST(Trajectory, SwathsOfThePassesCoverTheWholeExtent) {
  const Trajectory t = Trajectory::plan(flight(), {}, kExtent, kFlat, 1);
  const double half = 0.5 * t.swath_m(500.0);
  for (double x = kExtent.min_x; x <= kExtent.max_x; x += 50.0) {
    for (double y = kExtent.min_y; y <= kExtent.max_y; y += 50.0) {
      bool is_seen = false;
      for (const Pass& pass : t.passes()) {
        const Vec3d along = normalized(pass.end - pass.start);
        const Vec3d from = Vec3d{x, y, 0.0} - pass.start;
        const double ahead = from.x * along.x + from.y * along.y;
        const double aside = from.x * along.y - from.y * along.x;
        is_seen |= ahead >= 0.0 && ahead <= norm(pass.end - pass.start) && std::abs(aside) <= half;
      }
      EXPECT_TRUE(is_seen) << x << " " << y;
    }
  }
}

TEST(Trajectory, WithoutMotionTheAircraftFliesStraightAndLevel) {
  FlightOptions options = flight();
  options.motion = 0.0;
  const Trajectory t = Trajectory::plan(options, {}, kExtent, kFlat, 1);
  for (std::size_t i = 0; i < t.passes().size(); ++i) {
    const Pass& pass = t.passes()[i];
    const SensorFrame frame = t.at(i, 0.5 * (pass.first_time_s + pass.last_time_s));
    EXPECT_NEAR(norm(frame.position - 0.5 * (pass.start + pass.end)), 0.0, 1e-4);
    EXPECT_NEAR(frame.down.z, -1.0, 1e-12);
    EXPECT_NEAR(frame.forward.x, std::sin(pass.azimuth_deg * kRadians), 1e-12);
    EXPECT_NEAR(frame.position.z, 1700.0, 1e-9);
  }
}

TEST(Trajectory, PositionBetweenPosesIsTheirLinearInterpolation) {
  const Trajectory t = Trajectory::plan(flight(), {}, kExtent, kFlat, 7);
  const Pass& pass = t.passes()[1];
  const TrajectoryPose &a = t.poses()[pass.first_node + 100], &b = t.poses()[pass.first_node + 101];
  const double time = a.gps_time_s + 0.0037;
  const double u = (time - a.gps_time_s) / (b.gps_time_s - a.gps_time_s);
  EXPECT_NEAR(norm(t.at(1, time).position - (a.position + u * (b.position - a.position))), 0.0,
              2e-5);
}

TEST(Trajectory, IsSmoothOverLinesAndTurns) {
  const Trajectory t = Trajectory::plan(flight(), {}, kExtent, kFlat, 3);
  bool has_turn = false;
  for (std::size_t i = 1; i < t.poses().size(); ++i) {
    const TrajectoryPose &a = t.poses()[i - 1], &b = t.poses()[i];
    const double dt = b.gps_time_s - a.gps_time_s;
    ASSERT_GT(dt, 0.0);
    ASSERT_LE(dt, 0.11);
    ASSERT_LT(norm(b.position - a.position), 150.0 * dt) << i;
    ASSERT_LT(std::abs(wrapped(b.heading_deg - a.heading_deg)), 25.0 * dt + 1e-6) << i;
    ASSERT_LT(std::abs(b.roll_deg - a.roll_deg), 30.0 * dt + 1e-6) << i;
    has_turn |= b.pass < 0 && std::abs(b.roll_deg) > 10.0;
  }
  EXPECT_TRUE(has_turn) << "an aircraft banks in turns";
}

TEST(Trajectory, SpeedAndAttitudeVaryWithinWhatAnAircraftDoes) {
  const Trajectory t = Trajectory::plan(flight(), {}, kExtent, kFlat, 3);
  double slowest = 1e9, fastest = 0.0, most_roll = 0.0;
  for (std::size_t i = 1; i < t.poses().size(); ++i) {
    const TrajectoryPose &a = t.poses()[i - 1], &b = t.poses()[i];
    if (a.pass < 0 || b.pass != a.pass) continue;
    const double speed = std::hypot(b.position.x - a.position.x, b.position.y - a.position.y) /
                         (b.gps_time_s - a.gps_time_s);
    slowest = std::min(slowest, speed);
    fastest = std::max(fastest, speed);
    most_roll = std::max(most_roll, std::abs(b.roll_deg));
  }
  EXPECT_GT(slowest, 52.0);
  EXPECT_LT(fastest, 68.0);
  EXPECT_GT(fastest - slowest, 1.0);
  EXPECT_GT(most_roll, 0.3);
  EXPECT_LE(most_roll, 1.5);
}

TEST(Trajectory, ScanAngleIsPositiveToTheRightOfFlightAndHoldsTheRoll) {
  FlightOptions options = flight();
  options.motion = 0.0;
  options.azimuth_deg = 0.0;
  const Trajectory t = Trajectory::plan(options, {}, kExtent, kFlat, 1);
  SensorFrame frame = t.at(0, t.passes()[0].first_time_s + 1.0);
  // Northbound, east is to the right.
  EXPECT_NEAR(across_track_angle_deg(frame, normalized(Vec3d{1.0, 0.0, -1.0})), 45.0, 1e-9);
  EXPECT_NEAR(across_track_angle_deg(frame, normalized(Vec3d{-1.0, 5.0, -1.0})), -45.0, 1e-9);
  // The right wing goes down by 10 degrees: the mirror's nadir now looks to the left.
  const double roll = 10.0 * kRadians;
  const Vec3d right = frame.right, down = frame.down;
  frame.right = std::cos(roll) * right + std::sin(roll) * down;
  frame.down = std::cos(roll) * down - std::sin(roll) * right;
  EXPECT_NEAR(across_track_angle_deg(frame, frame.to_world({0.0, 0.0, 1.0})), -10.0, 1e-9);
}

TEST(Trajectory, PosesOfPositiveRollHaveTheRightWingDown) {
  const Trajectory t = Trajectory::plan(flight(), {}, kExtent, kFlat, 11);
  const Pass& pass = t.passes()[0];
  int checked = 0;
  for (std::size_t n = 0; n < pass.node_count; n += 50) {
    const TrajectoryPose& pose = t.poses()[pass.first_node + n];
    if (std::abs(pose.roll_deg) < 0.05) continue;
    const SensorFrame frame = t.at(0, pose.gps_time_s);
    EXPECT_EQ(frame.right.z<0.0, pose.roll_deg> 0.0);
    EXPECT_NEAR(std::asin(frame.forward.z) / kRadians, pose.pitch_deg, 1e-4);
    EXPECT_NEAR(wrapped(std::atan2(frame.forward.x, frame.forward.y) / kRadians - pose.heading_deg),
                0.0, 1e-4);
    ++checked;
  }
  EXPECT_GT(checked, 5);
}

TEST(Trajectory, ACrossLineIsFlownLastAndAcross) {
  FlightOptions options = flight();
  const std::size_t without = Trajectory::plan(options, {}, kExtent, kFlat, 1).passes().size();
  options.cross_line = true;
  const Trajectory t = Trajectory::plan(options, {}, kExtent, kFlat, 1);
  ASSERT_EQ(t.passes().size(), without + 1);
  EXPECT_TRUE(t.passes().back().is_cross_line);
  EXPECT_NEAR(t.passes().back().azimuth_deg, 110.0, 1e-9);
}

TEST(Trajectory, TheSecondSurveyStartsAfterTheBreakWithoutPosesInBetween) {
  FlightOptions options = flight();
  options.survey_break_s = 44.0 * 86400.0;
  const Trajectory t = Trajectory::plan(options, {}, kExtent, kFlat, 1);
  EXPECT_EQ(t.passes().front().survey, 0);
  EXPECT_EQ(t.passes().back().survey, 1);
  EXPECT_GT(t.passes().back().first_time_s - t.passes().front().last_time_s, 44.0 * 86400.0);
  EXPECT_LT(t.poses().size(), 200000u);
}

TEST(Trajectory, HeightsThatCannotBeFlownAreRefusedWithWhatWouldDo) {
  const GroundRange steep{500.0, 1000.0, 2300.0};
  try {
    Trajectory::plan(flight(), {}, kExtent, steep, 1);
    FAIL() << "flew into the mountain";
  } catch (const UsageError& error) {
    EXPECT_EQ(error.subject(), "--height");
    EXPECT_NE(std::string(error.what()).find("at least 1400 m"), std::string::npos) << error.what();
  }
  FlightOptions options = flight();
  options.speed_ms = 5.0;
  EXPECT_THROW(Trajectory::plan(options, {}, kExtent, kFlat, 1), UsageError);
  options = flight();
  options.overlap = 0.9;
  EXPECT_THROW(Trajectory::plan(options, {}, kExtent, kFlat, 1), UsageError);
}

}  // namespace
}  // namespace cornice::simulate
