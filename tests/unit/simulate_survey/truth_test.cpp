// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/truth.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/io/flight_lines_file.h"
#include "core/io/ply.h"
#include "support/temporary_folder.h"

namespace cornice::simulate {
namespace {

SurveyPoint some_point() {
  SurveyPoint point;
  point.at = {274600123, 123400456, 150078};
  point.true_offset = {0.01f, -0.02f, 0.03f};
  point.normal = {0.0f, 0.6f, 0.8f};
  point.beam = {0.0f, 0.0f, -1.0f};
  point.surface = 3;
  point.line = 7;
  return point;
}

TEST(TruthPly, RowsComeBackThroughTheProjectsReader) {
  const test::TemporaryFolder folder;
  const Vec3d origin{2746000.0, 1234000.0, 1500.0};
  TruthPly ply(folder / "a.ply", origin, "EPSG:2056+5728");
  std::vector<char> rows;
  for (int i = 0; i < 12345; ++i) TruthPly::append_row(some_point(), origin, rows);
  ply.write(rows);
  ply.write(rows);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.ply")) << "must not appear before it is whole";
  ply.close();
  const OrientedPoints points = read_ply_points(folder / "a.ply");
  ASSERT_EQ(points.positions.size(), 24690u);
  EXPECT_EQ(points.origin, origin);
  EXPECT_EQ(points.crs_text, "EPSG:2056+5728");
  EXPECT_NEAR(points.positions[9].x, 1.23 + 0.01, 1e-5);
  EXPECT_NEAR(points.positions[9].y, 4.56 - 0.02, 1e-5);
  EXPECT_NEAR(points.positions[9].z, 0.78 + 0.03, 1e-4);
  EXPECT_EQ(points.normals[9].y, 0.6f);
  ASSERT_EQ(points.line_id.size(), 24690u);
  EXPECT_EQ(points.line_id[24689], 7);
  ASSERT_EQ(points.byte_properties.size(), 1u);
  EXPECT_EQ(points.byte_properties[0].name, "surface");
  EXPECT_EQ(points.byte_properties[0].values[3], 3);
  ASSERT_EQ(points.float_properties.size(), 3u);
  EXPECT_EQ(points.float_properties[2].values[0], -1.0f);
}

TEST(TruthPly, ATileWithoutPointsIsAWholeFile) {
  const test::TemporaryFolder folder;
  TruthPly ply(folder / "a.ply", {}, "EPSG:2154+5720");
  ply.close();
  EXPECT_TRUE(read_ply_points(folder / "a.ply").positions.empty());
}

TEST(TruthExtraBytes, LayoutMatchesTheBytes) {
  std::vector<std::uint8_t> bytes;
  append_truth_extra_bytes(some_point(), bytes);
  ASSERT_EQ(bytes.size(), truth_extra_size());
  const auto entries = truth_extra_bytes();
  std::size_t end = 0;
  for (const ExtraByte& entry : entries) {
    EXPECT_EQ(entry.offset, end);
    end += entry.size;
  }
  EXPECT_EQ(end, bytes.size());
  float normal_z = 0.0f;
  ASSERT_EQ(entries[5].name, "normal_z");
  std::memcpy(&normal_z, bytes.data() + entries[5].offset, sizeof normal_z);
  EXPECT_EQ(normal_z, 0.8f);
}

class TruthLines : public testing::Test {
 protected:
  TruthLines() {
    FlightOptions flight;
    flight.start_time_s = 3e8;
    trajectory_.emplace(
        Trajectory::plan(flight, {}, {2746000, 1234000, 2746500, 1234500}, {500, 500, 500}, 1));
    lines_ = survey_lines(*trajectory_, 1, ChannelTag::kPointSourceId, {}, 1);
    for (const SurveyLine& line : lines_) {
      const Pass& pass = trajectory_->passes()[static_cast<std::size_t>(line.pass)];
      LineTally tally;
      tally.points = 1000;
      tally.first_time_s = tally.true_first_time_s = pass.first_time_s + 1.0;
      tally.last_time_s = tally.true_last_time_s = pass.last_time_s - 1.0;
      tallies_.push_back(tally);
    }
  }
  std::optional<Trajectory> trajectory_;
  std::vector<SurveyLine> lines_;
  std::vector<LineTally> tallies_;
  LinesHeader header_{"EPSG:2056+5728", "oscillating", 1e5, 40.0, {0.0, 6.5}};
};

TEST_F(TruthLines, AreFlightLinesThatEveryStageCanRead) {
  const test::TemporaryFolder folder;
  const auto truths = line_truths(*trajectory_, lines_, tallies_, {}, 500.0);
  write_lines_json(folder / "lines.json", truths, header_);
  write_lines_geopackage(folder / "lines.gpkg", truths, header_);
  for (const char* name : {"lines.json", "lines.gpkg"}) {
    const FlightLines read = read_flight_lines(folder / name);
    EXPECT_EQ(read.crs_text, "EPSG:2056+5728") << name;
    ASSERT_EQ(read.lines.size(), lines_.size()) << name;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      const FlightLine& line = read.lines[i];
      EXPECT_EQ(line.id, i + 1);
      EXPECT_EQ(line.point_source_id, lines_[i].point_source_id);
      EXPECT_EQ(line.scan_angle_sign, 1);
      EXPECT_NEAR(line.first_time_s, tallies_[i].first_time_s, 1e-6);
      const double time = 0.5 * (line.first_time_s + line.last_time_s);
      const auto sensor = sensor_at(line, time);
      ASSERT_TRUE(sensor.has_value());
      EXPECT_LT(norm(*sensor - trajectory_->at(i, time).position), 0.005) << name;
      const double azimuth = trajectory_->passes()[i].azimuth_deg;
      EXPECT_LT(std::abs(std::remainder(line.along_azimuth_deg - azimuth, 360.0)), 4.0);
      EXPECT_LT(std::abs(std::remainder(line.across_azimuth_deg - azimuth - 90.0, 360.0)), 8.0);
    }
  }
}

TEST_F(TruthLines, GoOnAboveAWeekWhereTheWeekEnds) {
  DefectOptions defects;
  defects.week_rollover = true;
  const double shift = kWeekS - recorded_time(defects, trajectory_->passes()[0].first_time_s) - 4.0;
  FlightOptions flight;
  flight.start_time_s = 3e8 + shift;
  const Trajectory later =
      Trajectory::plan(flight, {}, {2746000, 1234000, 2746500, 1234500}, {500, 500, 500}, 1);
  std::vector<LineTally> tallies(lines_.size());
  const auto truths = line_truths(later, lines_, tallies, defects, 500.0);
  EXPECT_LT(truths[0].nodes.front().time_s, kWeekS);
  EXPECT_GT(truths[0].nodes.back().time_s, kWeekS);
  for (std::size_t i = 1; i < truths[0].nodes.size(); ++i)
    EXPECT_GT(truths[0].nodes[i].time_s, truths[0].nodes[i - 1].time_s);
}

TEST_F(TruthLines, WrittenTwiceAreTheSameBytes) {
  const test::TemporaryFolder folder;
  const auto truths = line_truths(*trajectory_, lines_, tallies_, {}, 500.0);
  for (const char* name : {"a.gpkg", "b.gpkg"})
    write_lines_geopackage(folder / name, truths, header_);
  for (const char* name : {"a.csv", "b.csv"}) write_trajectory_csv(folder / name, *trajectory_, {});
  EXPECT_EQ(test::read_text(folder / "a.gpkg"), test::read_text(folder / "b.gpkg"));
  EXPECT_EQ(test::read_text(folder / "a.csv"), test::read_text(folder / "b.csv"));
}

}  // namespace
}  // namespace cornice::simulate
