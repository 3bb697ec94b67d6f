// SPDX-License-Identifier: GPL-3.0-or-later
// Flight lines of real files: lines, channels and signs as they are known, paths against those that
// others made, and of one line against itself from the next tile.
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stages/flightlines/survey_lines.h"

namespace cornice::flightlines {
namespace {

namespace fs = std::filesystem;

const fs::path kData = CORNICE_TEST_DATA;

SurveyLines lines_of(const std::vector<std::string>& names) {
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(kData / name);
  MemoryBudget memory;
  SurveyOptions options;
  options.threads = 2;
  return find_survey_lines(files, options, memory);
}

#define NEEDS_DATA() \
  if (!fs::exists(kData / "bcts_ca")) GTEST_SKIP() << "no folder of real data: " << kData

double off(double a_deg, double b_deg) { return std::abs(std::remainder(a_deg - b_deg, 360.0)); }

/// Sensor positions of a trajectory file, by source id and time.
std::map<int, std::map<double, Vec3d>> witness_of(const fs::path& file) {
  GDALAllRegister();
  std::map<int, std::map<double, Vec3d>> witness;
  GDALDatasetH dataset =
      GDALOpenEx(file.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr);
  if (dataset == nullptr) return witness;
  OGRLayerH layer = GDALDatasetGetLayer(dataset, 0);
  while (OGRFeatureH feature = OGR_L_GetNextFeature(layer)) {
    const OGRGeometryH point = OGR_F_GetGeometryRef(feature);
    const int id = OGR_F_GetFieldAsInteger(feature, OGR_F_GetFieldIndex(feature, "PointSourceID"));
    const double time = OGR_F_GetFieldAsDouble(feature, OGR_F_GetFieldIndex(feature, "gpstime"));
    witness[id][time] = {OGR_G_GetX(point, 0), OGR_G_GetY(point, 0), OGR_G_GetZ(point, 0)};
    OGR_F_Destroy(feature);
  }
  GDALClose(dataset);
  return witness;
}

class Witness : public testing::TestWithParam<const char*> {};

TEST_P(Witness, HasItsSensorWithinTenMetresOfOurs) {
  NEEDS_DATA();
  const std::string name = std::string("ign_lidarforfuel/") + GetParam();
  const SurveyLines survey = lines_of({name + ".laz"});
  const auto witness = witness_of(kData / (name + ".gpkg"));
  std::size_t compared = 0;
  for (const LineEstimate& e : survey.lines) {
    ASSERT_EQ(e.line.beam_source, BeamSource::kTrajectory) << e.line.beam_reason;
    const auto found = witness.find(e.line.point_source_id);
    ASSERT_NE(found, witness.end());
    for (const auto& [time, position] : found->second) {
      if (time < e.line.first_time_s || time > e.line.last_time_s) continue;
      EXPECT_LT(norm(*sensor_at(e.line, time) - position), 10.0) << time;
      ++compared;
    }
  }
  EXPECT_GT(compared, 5u);
}

INSTANTIATE_TEST_SUITE_P(LidarHd, Witness, testing::Values("1_42", "2_42", "2_bas_lig"));

TEST(RealLines, HaveReversedSignsInOneBlockAndNotInAnother) {
  NEEDS_DATA();
  const SurveyLines reversed = lines_of({"ign_lidarforfuel/1_42.laz"});
  ASSERT_EQ(reversed.lines.size(), 2u);
  for (const LineEstimate& e : reversed.lines) EXPECT_EQ(e.line.scan_angle_sign, -1);
  const SurveyLines right = lines_of({"ign_lidarforfuel/2_bas_lig.laz"});
  ASSERT_EQ(right.lines.size(), 2u);
  for (const LineEstimate& e : right.lines) EXPECT_EQ(e.line.scan_angle_sign, 1);
  // Its two channels look fore and aft.
  EXPECT_NEAR(right.lines[0].lean_deg, 6.5, 1.0);
  EXPECT_NEAR(right.lines[1].lean_deg, -4.5, 1.0);
}

TEST(RealLines, AreThreeOverFourTilesAndAgreeWhereTilesMeet) {
  NEEDS_DATA();
  std::vector<std::string> names;
  for (const int i : {1, 2, 3, 4}) names.push_back("bcts_ca/bcts_" + std::to_string(i) + ".laz");
  const SurveyLines all = lines_of(names);
  ASSERT_EQ(all.lines.size(), 3u);
  for (const LineEstimate& e : all.lines) {
    EXPECT_EQ(e.line.beam_source, BeamSource::kTrajectory);
    EXPECT_EQ(e.line.scan_angle_sign, 1);
    EXPECT_LT(std::abs(e.perpendicular_deg), 3.0);
  }
  EXPECT_LT(off(all.lines[0].line.along_azimuth_deg, 357.0), 3.0);
  EXPECT_LT(off(all.lines[1].line.along_azimuth_deg, 177.0), 3.0);
  EXPECT_GE(all.overlaps.size(), 3u);
  for (const OverlapPair& pair : all.overlaps) EXPECT_LT(std::abs(pair.median_dz_m), 0.1);
  const SurveyLines south = lines_of({names[1]}), north = lines_of({names[2]});
  std::size_t met = 0;
  for (const LineEstimate& a : south.lines)
    for (const LineEstimate& b : north.lines) {
      if (a.line.point_source_id != b.line.point_source_id) continue;
      const double time = 0.5 * (std::min(a.line.last_time_s, b.line.last_time_s) +
                                 std::max(a.line.first_time_s, b.line.first_time_s));
      const auto sa = sensor_at(a.line, time), sb = sensor_at(b.line, time);
      if (!sa || !sb) continue;
      EXPECT_LT(norm(*sa - *sb), 10.0) << a.line.point_source_id;
      ++met;
    }
  EXPECT_GE(met, 2u);
}

TEST(RealLines, OfTheCliffAreTwoPassesUnderEachId) {
  NEEDS_DATA();
  const SurveyLines survey = lines_of({"ign_mnx/corse.laz"});
  ASSERT_EQ(survey.lines.size(), 4u);
  for (const int id : {0, 1}) {
    std::size_t count = 0;
    for (const LineEstimate& e : survey.lines) count += e.line.point_source_id == id;
    EXPECT_EQ(count, 2u);
  }
}

TEST(RealLines, LeaveVirtualPointsOut) {
  NEEDS_DATA();
  const SurveyLines survey = lines_of({"ign_mnx/pont.laz"});
  EXPECT_EQ(survey.invalid[static_cast<std::size_t>(Invalid::kVirtualClass)], 24006u);
  ASSERT_EQ(survey.lines.size(), 2u);
  for (const LineEstimate& e : survey.lines) EXPECT_EQ(e.line.scan_angle_sign, -1);
}

TEST(RealLines, OfAConicalScannerCrossTwoTilesAndAgreeWithTheirAngles) {
  NEEDS_DATA();
  const SurveyLines survey =
      lines_of({"ign_adjacent_1km/test_semis_2023_0299_6802_LA93_IGN69.laz",
                "ign_adjacent_1km/test_semis_2023_0300_6802_LA93_IGN69.laz"});
  std::size_t timed = 0;
  for (const LineEstimate& e : survey.lines) {
    if (!e.line.has_time) continue;
    ++timed;
    EXPECT_EQ(e.scan_model, ScanModel::kCone);
    EXPECT_EQ(e.looks, 2);
    EXPECT_EQ(e.line.beam_source, BeamSource::kTrajectory) << e.line.beam_reason;
    EXPECT_LT(std::abs(e.perpendicular_deg), 3.0);
    EXPECT_LT(e.angle_residual_deg, 0.05);
  }
  EXPECT_EQ(timed, 4u);
}

TEST(RealLines, OfAConicalScannerAgreeWhereTwoTilesMeet) {
  NEEDS_DATA();
  const std::string start = "ign_adjacent_1km/test_semis_2023_0";
  const SurveyLines west = lines_of({start + "299_6802_LA93_IGN69.laz"});
  const SurveyLines east = lines_of({start + "300_6802_LA93_IGN69.laz"});
  std::size_t met = 0;
  for (const LineEstimate& a : west.lines)
    for (const LineEstimate& b : east.lines) {
      if (!a.line.has_time || !b.line.has_time ||
          a.line.point_source_id != b.line.point_source_id ||
          a.line.scanner_channel != b.line.scanner_channel)
        continue;
      const double time = 0.5 * (std::min(a.line.last_time_s, b.line.last_time_s) +
                                 std::max(a.line.first_time_s, b.line.first_time_s));
      const auto sa = sensor_at(a.line, time), sb = sensor_at(b.line, time);
      if (!sa || !sb) continue;
      // Each end is the worst known place of its path: 11 m were met, a third of a degree of beam.
      EXPECT_LT(norm(*sa - *sb), 15.0) << a.line.point_source_id;
      ++met;
    }
  EXPECT_GE(met, 1u);
}

TEST(RealLines, OverOneBuildingKeepOnlyPathsThatAgreeInHeight) {
  NEEDS_DATA();
  const SurveyLines survey = lines_of({"ign_mnx/bat.laz"});
  ASSERT_EQ(survey.lines.size(), 9u);
  // Clips of a second with whole degrees: two know their height, the others would be off by a
  // kilometre.
  std::size_t kept = 0;
  for (const LineEstimate& e : survey.lines) {
    if (e.line.beam_source != BeamSource::kTrajectory) {
      EXPECT_FALSE(e.line.beam_reason.empty());
      continue;
    }
    ++kept;
    EXPECT_NEAR(e.height_m, 1240.0, 60.0) << e.line.point_source_id;
  }
  EXPECT_EQ(kept, 2u);
}

TEST(RealLines, WithoutTimesAndAnglesAreOneLineWithVerticalBeams) {
  NEEDS_DATA();
  const SurveyLines survey = lines_of({"misc_als/pdal_hexbin-crop_afghanistan.las"});
  ASSERT_EQ(survey.lines.size(), 1u);
  EXPECT_FALSE(survey.lines[0].line.has_time);
  EXPECT_EQ(survey.lines[0].line.beam_source, BeamSource::kVertical);
  EXPECT_FALSE(survey.channel_in_user_data);
}

}  // namespace
}  // namespace cornice::flightlines
