// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/flight_line.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>

namespace cornice {
namespace {

FlightLine line_of(std::uint16_t id, std::uint8_t channel, double first, double last) {
  FlightLine line;
  line.point_source_id = id;
  line.scanner_channel = channel;
  line.first_time_s = first;
  line.last_time_s = last;
  return line;
}

FlightLines some_lines() {
  FlightLines all;
  all.lines = {line_of(1, 0, 100, 110), line_of(1, 1, 100, 110), line_of(2, 0, 100, 110),
               line_of(1, 0, 500, 510)};
  for (std::size_t i = 0; i < all.lines.size(); ++i)
    all.lines[i].id = static_cast<std::uint32_t>(i + 1);
  return all;
}

TEST(FlightLines, FindTheLineByIdChannelAndTime) {
  const FlightLines all = some_lines();
  EXPECT_EQ(all.find(1, 0, 105.0), 0u);
  EXPECT_EQ(all.find(1, 1, 105.0), 1u);
  EXPECT_EQ(all.find(2, 0, 105.0), 2u);
  EXPECT_EQ(all.find(1, 0, 505.0), 3u);
  EXPECT_EQ(all.find(1, 0, 110.4), 0u);
  EXPECT_FALSE(all.find(1, 0, 111.0));
  EXPECT_FALSE(all.find(3, 0, 105.0));
}

TEST(LineFinder, GivesWhatFlightLinesFindGives) {
  const FlightLines all = some_lines();
  LineFinder finder(all);
  for (const std::uint16_t id : std::initializer_list<std::uint16_t>{1, 2, 3})
    for (const std::uint8_t channel : std::initializer_list<std::uint8_t>{0, 1})
      for (double time = 99.0; time < 512.0; time += 0.3)
        ASSERT_EQ(finder.find(id, channel, time), all.find(id, channel, time)) << time;
}

TEST(LineFinder, TellsChannelsByUserDataWhereALineSaysSo) {
  FlightLines all = some_lines();
  for (FlightLine& line : all.lines) line.channel_in_user_data = true;
  LineFinder finder(all);
  EXPECT_EQ(finder.find(1, 0, 105.0, 1), 1u);
  EXPECT_EQ(finder.find(1, 0, 105.0, 0), 0u);
}

TEST(FlightLines, KnowALineThatCrossesTheEndOfTheWeek) {
  FlightLines all;
  all.lines = {line_of(1, 0, 604790.0, 604810.0)};
  EXPECT_EQ(all.find(1, 0, 5.0), 0u);
  EXPECT_EQ(all.find(1, 0, 604795.0), 0u);
  EXPECT_FALSE(all.find(1, 0, 100.0));
  EXPECT_DOUBLE_EQ(time_on_line(all.lines[0], 5.0), 604805.0);
}

TEST(FlightLines, MatchEveryTimeOfALineWithoutTimes) {
  FlightLines all;
  all.lines = {line_of(1, 0, 0.0, 0.0)};
  all.lines[0].has_time = false;
  EXPECT_EQ(all.find(1, 0, 12345.0), 0u);
}

FlightLine straight_line() {
  FlightLine line = line_of(1, 0, 10.0, 12.0);
  line.beam_source = BeamSource::kTrajectory;
  line.across_azimuth_deg = 90.0;
  line.scan_angle_sign = 1;
  for (int i = 0; i < 3; ++i) {
    TrajectoryNode node;
    node.gps_time_s = 10.0 + i;
    node.position = {0.0, 60.0 * i, 1000.0};
    line.nodes.push_back(node);
  }
  return line;
}

TEST(SensorAt, InterpolatesAndGoesOneStepBeyondTheEnds) {
  const FlightLine line = straight_line();
  EXPECT_EQ(*sensor_at(line, 10.5), (Vec3d{0.0, 30.0, 1000.0}));
  EXPECT_EQ(*sensor_at(line, 9.5), (Vec3d{0.0, -30.0, 1000.0}));
  EXPECT_EQ(*sensor_at(line, 12.5), (Vec3d{0.0, 150.0, 1000.0}));
  EXPECT_FALSE(sensor_at(line, 8.9));
  EXPECT_FALSE(sensor_at(line, 13.1));
  EXPECT_FALSE(sensor_at(FlightLine{}, 10.0));
}

TEST(BeamAt, ComesFromThePathThenTheAngleThenStraightDownAndSaysWhich) {
  FlightLine line = straight_line();
  BeamSource used = BeamSource::kVertical;
  const Vec3d beam = beam_at(line, 11.0, {1000.0, 60.0, 0.0}, -45.0, &used);
  EXPECT_EQ(used, BeamSource::kTrajectory);
  EXPECT_NEAR(beam.x, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(beam.z, -std::sqrt(0.5), 1e-12);
  // Outside of the path: the angle, which here has the other sign.
  const Vec3d by_angle = beam_at(line, 100.0, {}, -45.0, &used);
  EXPECT_EQ(used, BeamSource::kAngles);
  EXPECT_NEAR(by_angle.x, -std::sqrt(0.5), 1e-12);
  line.scan_angle_sign = -1;
  EXPECT_NEAR(beam_at(line, 100.0, {}, -45.0).x, std::sqrt(0.5), 1e-12);
  line.scan_angle_sign = 0;
  EXPECT_EQ(beam_at(line, 100.0, {}, -45.0, &used), (Vec3d{0.0, 0.0, -1.0}));
  EXPECT_EQ(used, BeamSource::kVertical);
}

}  // namespace
}  // namespace cornice
