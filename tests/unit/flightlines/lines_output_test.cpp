// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/lines_output.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"
#include "core/io/flight_lines_file.h"
#include "tests/support/temporary_folder.h"

namespace cornice::flightlines {
namespace {

namespace fs = std::filesystem;

class LinesFiles : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
};

SurveyLines small_survey() {
  SurveyLines survey;
  survey.crs = crs_from_text("EPSG:2056+5728");
  LineEstimate e;
  e.line.id = 1;
  e.line.point_source_id = 65535;
  e.line.scanner_channel = 2;
  e.line.first_time_s = 300000000.123456;
  e.line.last_time_s = 300000001.5;
  e.line.along_azimuth_deg = 20.25;
  e.line.across_azimuth_deg = 110.5;
  e.line.across_standard_error_deg = 0.01;
  e.line.scan_angle_sign = -1;
  e.line.beam_source = BeamSource::kTrajectory;
  for (int i = 0; i < 3; ++i) {
    TrajectoryNode node;
    node.gps_time_s = 300000000.123456 + 0.5 * i;
    node.position = {2700000.125 + i, 1200000.5 + 30 * i, 2500.75};
    node.standard_error_m = {0.1f, 0.2f, 0.3f};
    node.bridged = i == 1;
    e.line.nodes.push_back(node);
  }
  survey.lines.push_back(e);
  e.line.id = 2;
  e.line.point_source_id = 3;
  e.line.nodes.clear();
  e.line.beam_source = BeamSource::kAngles;
  e.line.beam_reason = "too few pulses for a path";
  e.line.has_time = false;
  survey.lines.push_back(e);
  survey.overlaps.push_back({1, 2, 0.05, 0.02, 321});
  TileCounts tile;
  tile.file = "tile.laz";
  tile.invalid[0] = 17;
  survey.tiles.push_back(tile);
  return survey;
}

void expect_same(const FlightLines& a, const FlightLines& b) {
  EXPECT_EQ(a.crs_text, b.crs_text);
  ASSERT_EQ(a.lines.size(), b.lines.size());
  for (std::size_t i = 0; i < a.lines.size(); ++i) {
    const FlightLine& x = a.lines[i];
    const FlightLine& y = b.lines[i];
    EXPECT_EQ(x.id, y.id);
    EXPECT_EQ(x.point_source_id, y.point_source_id);
    EXPECT_EQ(x.scanner_channel, y.scanner_channel);
    EXPECT_EQ(x.has_time, y.has_time);
    EXPECT_EQ(x.channel_in_user_data, y.channel_in_user_data);
    EXPECT_EQ(x.first_time_s, y.first_time_s);
    EXPECT_EQ(x.last_time_s, y.last_time_s);
    EXPECT_EQ(x.along_azimuth_deg, y.along_azimuth_deg);
    EXPECT_EQ(x.across_azimuth_deg, y.across_azimuth_deg);
    EXPECT_EQ(x.across_standard_error_deg, y.across_standard_error_deg);
    EXPECT_EQ(x.scan_angle_sign, y.scan_angle_sign);
    EXPECT_EQ(x.beam_source, y.beam_source);
    EXPECT_EQ(x.beam_reason, y.beam_reason);
    ASSERT_EQ(x.nodes.size(), y.nodes.size());
    for (std::size_t k = 0; k < x.nodes.size(); ++k) {
      EXPECT_EQ(x.nodes[k].gps_time_s, y.nodes[k].gps_time_s);
      EXPECT_EQ(x.nodes[k].position, y.nodes[k].position);
      EXPECT_EQ(x.nodes[k].standard_error_m, y.nodes[k].standard_error_m);
      EXPECT_EQ(x.nodes[k].bridged, y.nodes[k].bridged);
    }
  }
}

TEST_F(LinesFiles, ComeBackAsTheyWereFromBothFormats) {
  const SurveyLines survey = small_survey();
  write_json(folder_ / "a.json", survey);
  write_geopackage(folder_ / "a.gpkg", survey);
  expect_same(read_flight_lines(folder_ / "a.json"), survey.flight_lines());
  expect_same(read_flight_lines(folder_ / "a.gpkg"), survey.flight_lines());
}

TEST_F(LinesFiles, HaveTheSameBytesEachTime) {
  const SurveyLines survey = small_survey();
  for (const char* name : {"a", "b"}) {
    write_json(folder_ / (std::string(name) + ".json"), survey);
    write_geopackage(folder_ / (std::string(name) + ".gpkg"), survey);
  }
  EXPECT_EQ(test::read_text(folder_ / "a.json"), test::read_text(folder_ / "b.json"));
  EXPECT_EQ(test::read_text(folder_ / "a.gpkg"), test::read_text(folder_ / "b.gpkg"));
}

TEST_F(LinesFiles, AreRefusedWithOneClearLineWhereTheyAreSomethingElse) {
  const auto problem = [](const fs::path& path) -> std::string {
    try {
      read_flight_lines(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(problem(folder_ / "none.json").find("check the path"), std::string::npos);
  EXPECT_NE(problem(folder_ / "none.gpkg").find("check the path"), std::string::npos);
  std::ofstream(folder_ / "empty.gpkg");
  EXPECT_NE(problem(folder_ / "empty.gpkg").find("GeoPackage"), std::string::npos);
  EXPECT_NE(problem(folder_ / "lines.txt").find(".json or .gpkg"), std::string::npos);
  std::ofstream(folder_ / "other.json") << "{\"format\": \"else\"}";
  EXPECT_NE(problem(folder_ / "other.json").find("not flight lines"), std::string::npos);
  std::ofstream(folder_ / "cut.json") << "{\"format\": \"cornice fl";
  EXPECT_NE(problem(folder_ / "cut.json").find("no whole"), std::string::npos);
  SurveyLines survey = small_survey();
  std::swap(survey.lines[0].line.nodes[0], survey.lines[0].line.nodes[2]);
  write_json(folder_ / "order.json", survey);
  EXPECT_NE(problem(folder_ / "order.json").find("time order"), std::string::npos);
}

}  // namespace
}  // namespace cornice::flightlines
