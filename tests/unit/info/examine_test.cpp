// SPDX-License-Identifier: GPL-3.0-or-later
// Made files whose every fact is known.
#include "stages/info/examine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/las.h"
#include "core/io/ply.h"
#include "core/io/raster.h"
#include "stages/info/show.h"
#include "tests/support/temporary_folder.h"

namespace cornice::info {
namespace {

using test::TemporaryFolder;
using testing::Contains;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> ids(const FileFacts& file) {
  std::vector<std::string> result;
  for (const Defect& defect : file.defects) result.push_back(defect.id);
  return result;
}

LasWriteOptions tile_options() {
  LasWriteOptions options;
  options.offset = {2746000, 1234000, 0};
  options.crs = crs_from_text("EPSG:2056+5728");
  return options;
}

/// Two lines of a clean tile: 10,000 points, 4 a square metre, everything filled.
PointCloud clean_tile() {
  PointCloud cloud;
  for (int i = 0; i < 10000; ++i) {
    const int row = i / 100, column = i % 100;
    cloud.exact.push_back({50 * column, 50 * row, 100000 + column});
    cloud.positions.push_back({});
    cloud.gps_time_s.push_back(3.4e8 + 1e-3 * i + (i < 5000 ? 0.0 : 400.0));
    cloud.scan_angle_deg.push_back(static_cast<float>(-3.0 + 0.06 * column));
    cloud.return_number.push_back(1);
    cloud.return_count.push_back(1);
    cloud.classification.push_back(2);
    cloud.flags.push_back(0);
    cloud.point_source_id.push_back(i < 5000 ? 11 : 12);
    cloud.scanner_channel.push_back(0);
    cloud.user_data.push_back(0);
    cloud.intensity.push_back(static_cast<std::uint16_t>(100 + column));
  }
  return cloud;
}

FileFacts written(const TemporaryFolder& folder, const PointCloud& cloud,
                  const LasWriteOptions& options, const std::string& name = "tile.laz") {
  LasWriter writer(folder / name, options);
  writer.write(cloud);
  writer.close();
  return examine(folder / name);
}

TEST(Examine, FindsNothingWrongWithACleanTile) {
  const TemporaryFolder folder;
  const FileFacts file = written(folder, clean_tile(), tile_options());
  EXPECT_THAT(ids(file), IsEmpty());
  const auto& facts = std::get<PointFacts>(file.facts);
  EXPECT_EQ(facts.readable, 10000u);
  EXPECT_NEAR(*facts.density_per_m2, 4.0, 0.1);
  EXPECT_NEAR(facts.occupied_m2, 2500.0, 60.0);
  EXPECT_EQ(facts.classes[2], 10000u);
  EXPECT_EQ(facts.by_return[1], 10000u);
  EXPECT_EQ(facts.time.kind, TimeKind::kAdjustedStandard);
  EXPECT_EQ(facts.angle.distinct, 100u);
  EXPECT_FALSE(facts.angle.whole_degrees);
  EXPECT_EQ(facts.intensity_min, 100);
  EXPECT_EQ(facts.intensity_max, 199);
  ASSERT_EQ(facts.lines.size(), 2u);
  EXPECT_EQ(facts.lines[0].point_source_id, 11);
  EXPECT_EQ(facts.lines[1].passes, 1u);
}

TEST(Examine, SaysTheSameWithAnyNumberOfThreads) {
  const TemporaryFolder folder;
  LasWriteOptions options = tile_options();
  options.chunk_points = 500;
  written(folder, clean_tile(), options);
  const auto json_with = [&](int threads) {
    return json_text({{folder / "tile.laz", examine(folder / "tile.laz", {threads, ""}), ""}});
  };
  EXPECT_EQ(json_with(1), json_with(2));
}

struct Spoilt {
  const char* defect;
  void (*spoil)(PointCloud& cloud, LasWriteOptions& options);
};

class EachDefect : public testing::TestWithParam<Spoilt> {};

TEST_P(EachDefect, IsFoundAndIsOneLine) {
  const TemporaryFolder folder;
  PointCloud cloud = clean_tile();
  LasWriteOptions options = tile_options();
  GetParam().spoil(cloud, options);
  const FileFacts file = written(folder, cloud, options);
  EXPECT_THAT(ids(file), Contains(GetParam().defect));
  for (const Defect& defect : file.defects) {
    EXPECT_THAT(defect.text, Not(testing::HasSubstr("\n")));
    EXPECT_THAT(defect.text, Not(testing::EndsWith(".")));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Info, EachDefect,
    testing::Values(
        Spoilt{"crs_missing", [](PointCloud&, LasWriteOptions& o) { o.crs = {}; }},
        Spoilt{"no_vertical",
               [](PointCloud&, LasWriteOptions& o) { o.crs = crs_from_text("EPSG:2056"); }},
        Spoilt{"feet", [](PointCloud&, LasWriteOptions& o) { o.crs = crs_from_text("EPSG:2992"); }},
        Spoilt{"degrees",
               [](PointCloud&, LasWriteOptions& o) { o.crs = crs_from_text("EPSG:4326"); }},
        Spoilt{"mixed_units",
               [](PointCloud&, LasWriteOptions& o) { o.crs = crs_from_text("EPSG:2056+6360"); }},
        Spoilt{"virtual_points",
               [](PointCloud& c, LasWriteOptions&) {
                 c.classification[5] = 66;
                 c.gps_time_s[5] = 0.0;
               }},
        Spoilt{"zero_time", [](PointCloud& c, LasWriteOptions&) { c.gps_time_s[5] = 0.0; }},
        Spoilt{"negative_time", [](PointCloud& c, LasWriteOptions&) { c.gps_time_s[5] = -4e7; }},
        Spoilt{"bad_time",
               [](PointCloud& c, LasWriteOptions&) {
                 c.gps_time_s[5] = std::numeric_limits<double>::quiet_NaN();
               }},
        Spoilt{"no_good_time",
               [](PointCloud& c, LasWriteOptions&) {
                 std::fill(c.gps_time_s.begin(), c.gps_time_s.end(), 0.0);
               }},
        Spoilt{"constant_time",
               [](PointCloud& c, LasWriteOptions&) {
                 std::fill(c.gps_time_s.begin(), c.gps_time_s.end(), 3e8);
               }},
        Spoilt{"time_bit", [](PointCloud&,
                              LasWriteOptions& o) { o.gps_time_type = GpsTimeType::kWeekSeconds; }},
        Spoilt{"time_bit",
               [](PointCloud& c, LasWriteOptions&) {
                 for (double& time : c.gps_time_s) time -= 3.399e8;
               }},
        Spoilt{"time_not_adjusted",
               [](PointCloud& c, LasWriteOptions&) {
                 for (double& time : c.gps_time_s) time += 1e9;
               }},
        Spoilt{
            "time_order",
            [](PointCloud& c, LasWriteOptions&) { std::swap(c.gps_time_s[5], c.gps_time_s[500]); }},
        Spoilt{"shared_source_id",
               [](PointCloud& c, LasWriteOptions&) {
                 std::fill(c.point_source_id.begin(), c.point_source_id.end(), 3);
               }},
        Spoilt{"no_source_id",
               [](PointCloud& c, LasWriteOptions&) {
                 std::fill(c.point_source_id.begin(), c.point_source_id.end(), 0);
               }},
        Spoilt{"zero_angles",
               [](PointCloud& c, LasWriteOptions&) {
                 std::fill(c.scan_angle_deg.begin(), c.scan_angle_deg.end(), 0.0f);
               }},
        Spoilt{"whole_degrees",
               [](PointCloud& c, LasWriteOptions&) {
                 for (float& angle : c.scan_angle_deg) angle = std::round(angle);
               }},
        Spoilt{"absurd_angles",
               [](PointCloud& c, LasWriteOptions&) { c.scan_angle_deg[3] = 120.0f; }},
        Spoilt{"copies",
               [](PointCloud& c, LasWriteOptions&) {
                 c.exact[1] = c.exact[0];
                 c.gps_time_s[1] = c.gps_time_s[0];
               }},
        Spoilt{"repeated_returns",
               [](PointCloud& c, LasWriteOptions&) { c.gps_time_s[1] = c.gps_time_s[0]; }},
        Spoilt{"return_above_count",
               [](PointCloud& c, LasWriteOptions&) { c.return_number[7] = 3; }},
        Spoilt{"return_zero", [](PointCloud& c, LasWriteOptions&) { c.return_number[7] = 0; }},
        Spoilt{"unclassified",
               [](PointCloud& c, LasWriteOptions&) {
                 std::fill(c.classification.begin(), c.classification.end(), 1);
               }},
        Spoilt{"normalised",
               [](PointCloud& c, LasWriteOptions&) {
                 for (std::size_t i = 0; i < c.size(); ++i) c.exact[i].z = i % 2 == 0 ? 10 : 900;
                 for (std::size_t i = 1; i < c.size(); i += 2) c.classification[i] = 5;
               }},
        Spoilt{"no_time",
               [](PointCloud&, LasWriteOptions& o) {
                 o.version_minor = 2;
                 o.point_format = 0;
               }},
        Spoilt{"empty", [](PointCloud& c, LasWriteOptions&) { c = {}; }}),
    [](const auto& instance) {
      return std::string(instance.param.defect) + std::to_string(instance.index);
    });

TEST(Examine, FindsAHeaderThatDisagreesWithItsPoints) {
  const TemporaryFolder folder;
  LasWriteOptions options = tile_options();
  options.compress = false;
  written(folder, clean_tile(), options, "tile.las");
  std::string bytes = test::read_text(folder / "tile.las");
  const double wrong = 9e6;
  std::memcpy(&bytes[179], &wrong, 8);             // largest x
  bytes[255] = static_cast<char>(bytes[255] + 1);  // points of return 1
  test::write_text(folder / "tile.las", bytes);
  const auto found = ids(examine(folder / "tile.las"));
  EXPECT_THAT(found, Contains("bounds"));
  EXPECT_THAT(found, Contains("returns_header"));
}

TEST(Examine, GivesWhatIsReadableOfATruncatedFile) {
  const TemporaryFolder folder;
  for (const bool compress : {false, true}) {
    LasWriteOptions options = tile_options();
    options.compress = compress;
    options.chunk_points = 1000;
    written(folder, clean_tile(), options, "tile.laz");
    const std::string bytes = test::read_text(folder / "tile.laz");
    test::write_text(folder / "cut.laz", bytes.substr(0, bytes.size() / 2));
    const FileFacts file = examine(folder / "cut.laz");
    EXPECT_THAT(ids(file), Contains("truncated"));
    const auto& facts = std::get<PointFacts>(file.facts);
    EXPECT_GT(facts.readable, 1000u);
    EXPECT_LT(facts.readable, 9000u);
    EXPECT_THAT(screen_text(file), testing::HasSubstr("of 10,000"));
  }
}

TEST(Examine, RefusesWhatIsNoFileOfAnyKindItKnows) {
  const TemporaryFolder folder;
  test::write_text(folder / "notes.txt", "nothing to see");
  test::write_text(folder / "empty", "");
  test::write_text(folder / "notes.las", "nothing to see");
  test::write_text(folder / "cut.ply", "ply\nformat ascii 1.0\nelement vertex 3");
  for (const char* name : {"notes.txt", "empty", "notes.las", "cut.ply", "absent.laz", "."}) {
    testing::internal::CaptureStderr();
    EXPECT_THROW(examine(folder / name), InputError) << name;
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << name;
  }
}

TEST(Examine, LooksIntoOrientedPoints) {
  const TemporaryFolder folder;
  OrientedPoints points;
  points.origin = {2746000, 1234000, 500};
  points.crs_text = "EPSG:2056+5728";
  points.positions = {{1, 2, 3}, {10, 20, 30}, {5, 5, 5}};
  points.normals = {{0, 0, 1}, {1, 0, 0}, {0, 0.5f, 0}};
  points.quality = {1, 1, 1};
  write_ply(folder / "p.ply", points);
  const FileFacts file = examine(folder / "p.ply");
  const auto& facts = std::get<PlyFacts>(file.facts);
  EXPECT_EQ(facts.vertices, 3u);
  EXPECT_EQ(facts.faces, 0u);
  EXPECT_TRUE(facts.has_normals);
  EXPECT_EQ(facts.crs.text(), "EPSG:2056+5728");
  EXPECT_EQ(facts.bounds.min, (Vec3d{2746001, 1234002, 503}));
  EXPECT_EQ(facts.bounds.max, (Vec3d{2746010, 1234020, 530}));
  EXPECT_THAT(ids(file), testing::ElementsAre("normals_not_unit"));
}

TEST(Examine, LooksIntoARaster) {
  const TemporaryFolder folder;
  Raster raster;
  raster.width = 40;
  raster.height = 30;
  raster.west = 2746000;
  raster.north = 1235000;
  raster.step = 0.5;
  raster.crs = crs_from_text("EPSG:2056+5728");
  raster.values.assign(40 * 30, 500.0f);
  raster.at(3, 4) = raster.no_data;
  raster.at(5, 6) = 1500.0f;
  write_cog(folder / "dem.tif", raster);
  const FileFacts file = examine(folder / "dem.tif");
  const auto& facts = std::get<RasterFacts>(file.facts);
  EXPECT_EQ(facts.width, 40);
  EXPECT_EQ(facts.height, 30);
  EXPECT_EQ(facts.valid, 1199u);
  EXPECT_EQ(facts.min, 500.0);
  EXPECT_EQ(facts.max, 1500.0);
  EXPECT_DOUBLE_EQ(facts.step_x, 0.5);
  EXPECT_EQ(facts.bounds, (Box2d{2746000, 1234985, 2746020, 1235000}));
  EXPECT_EQ(facts.crs.horizontal_epsg, 2056);
  EXPECT_THAT(ids(file), IsEmpty());
}

TEST(Examine, FindsWhatIsWrongWithARaster) {
  const TemporaryFolder folder;
  Raster raster;
  raster.width = raster.height = 20;
  raster.west = 957000.25;
  raster.north = 6218000.25;
  raster.step = 0.5;
  raster.no_data = 9999.0f;
  raster.values.assign(400, 9999.0f);
  write_cog(folder / "a.tif", raster);
  EXPECT_THAT(
      ids(examine(folder / "a.tif")),
      testing::UnorderedElementsAre("crs_missing", "positive_no_data", "no_values", "off_grid"));
  write_cog(folder / "LHD_FXX_0957_6218_MNT_O_0M50_LAMB93_IGN69.tif", raster);
  EXPECT_THAT(ids(examine(folder / "LHD_FXX_0957_6218_MNT_O_0M50_LAMB93_IGN69.tif")),
              Contains("crs_from_name"));
  raster.crs = crs_from_text("EPSG:4326");
  write_cog(folder / "b.tif", raster);
  EXPECT_THAT(ids(examine(folder / "b.tif")), Contains("crs_wrong"));
}

TEST(Examine, FindsPixelsWithoutAValueThatNothingMarks) {
  const TemporaryFolder folder;
  Raster raster;
  raster.width = raster.height = 20;
  raster.west = 2600000.0, raster.north = 1200000.0;
  raster.crs = crs_from_text("EPSG:2056+5728");
  raster.values.assign(400, 500.0f);
  raster.values[7] = -3.4028235e38f;
  write_cog(folder / "a.tif", raster);
  EXPECT_THAT(ids(examine(folder / "a.tif")), testing::ElementsAre("no_data_unmarked"));
  raster.no_data = -3.4028235e38f;
  write_cog(folder / "b.tif", raster);
  EXPECT_THAT(ids(examine(folder / "b.tif")), IsEmpty());
}

TEST(ShowText, FitsOneScreen) {
  const TemporaryFolder folder;
  PointCloud cloud = clean_tile();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.point_source_id[i] = static_cast<std::uint16_t>(i / 100);
    cloud.classification[i] = static_cast<std::uint8_t>(i % 20);
  }
  const FileFacts file = written(folder, cloud, tile_options());
  const std::string text = screen_text(file);
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 45);
  EXPECT_THAT(text, testing::HasSubstr("and 88 more"));
  EXPECT_THAT(text, testing::HasSubstr("EPSG:2056+5728"));
  EXPECT_THAT(text, testing::EndsWith("\n"));
  const std::string line = summary_line(file);
  EXPECT_THAT(line, Not(testing::HasSubstr("\n")));
  EXPECT_THAT(line, testing::HasSubstr("10,000 points"));
}

TEST(ShowJson, HoldsTheFactsAndTheErrorsOfAllFiles) {
  const TemporaryFolder folder;
  const FileFacts file = written(folder, clean_tile(), tile_options());
  const auto json = nlohmann::json::parse(
      json_text({{file.path, file, ""}, {"bad\xff.laz", std::nullopt, "bad\xff.laz: is bad"}}));
  ASSERT_EQ(json["files"].size(), 2u);
  const auto& tile = json["files"][0];
  EXPECT_EQ(tile["kind"], "LAZ");
  EXPECT_EQ(tile["points"], 10000);
  EXPECT_EQ(tile["crs"]["text"], "EPSG:2056+5728");
  EXPECT_EQ(tile["classes"]["2"], 10000);
  EXPECT_EQ(tile["gps_time"]["type"], "adjusted_standard");
  EXPECT_EQ(tile["lines"].size(), 2u);
  EXPECT_TRUE(tile["defects"].empty());
  EXPECT_TRUE(json["files"][1].contains("error"));
}

}  // namespace
}  // namespace cornice::info
