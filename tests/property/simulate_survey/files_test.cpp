// SPDX-License-Identifier: GPL-3.0-or-later
// What a survey writes: tiles as the products have them, and truth in their order.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "core/io/las.h"
#include "core/io/ply.h"
#include "property/simulate_survey/flown.h"
#include "support/temporary_folder.h"

namespace cornice::test {
namespace {

using namespace simulate;
namespace fs = std::filesystem;

SurveyResult write_survey(const SurveyOptions& options, const fs::path& folder, int threads = 2) {
  PlaneScene scene = scene_for(options);
  scene.slope_x = 0.2;
  scene.canopy_west = scene.extent.min_x + 60.0;
  scene.canopy_east = scene.extent.max_x;
  scene.water_west = scene.extent.min_x + 40.0;
  scene.water_east = scene.extent.min_x + 50.0;
  const Survey survey(options, scene);
  MemoryBudget memory;
  SurveyResult result = fly_survey(survey, folder, threads, memory);
  write_survey_truth(survey, folder, result);
  return result;
}

std::map<std::string, std::string> contents_of(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      contents[entry.path().lexically_relative(folder).string()] = read_text(entry.path());
  return contents;
}

PointCloud read_tile(const fs::path& path) {
  LasReadOptions options;
  options.attributes = Attribute::kAll;
  return read_las(read_las_info(path), options).points;
}

struct Packing {
  const char* name;
  SurveyProduct product;
  TileContainer container;
  const char* defects;
};
void PrintTo(const Packing& p, std::ostream* out) { *out << p.name; }

class Files : public testing::TestWithParam<Packing> {
 protected:
  Files() : options_(small_survey()) {
    options_.product = GetParam().product;
    options_.container = GetParam().container;
    options_.truth_mesh_step_m = 10.0;
    if (GetParam().defects[0] != '\0') options_.defects = {GetParam().defects};
  }
  SurveyOptions options_;
};

TEST_P(Files, TruthIsInTheOrderOfTheTilesPoints) {
  const TemporaryFolder folder;
  const SurveyResult result = write_survey(options_, folder.path());
  std::uint64_t total = 0;
  for (int tile = 0; tile < 4; ++tile) {
    const std::string name = tile_name(options_.product, options_.container, tile_grid(options_),
                                       tile, options_.year, "plane");
    const PointCloud cloud = read_tile(folder / name);
    const OrientedPoints truth = read_ply_points(folder / ("truth/" + name + ".points.ply"));
    ASSERT_EQ(truth.positions.size(), cloud.size());
    ASSERT_GT(cloud.size(), 5000u);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Vec3d true_place = truth.origin + truth.positions[i].cast<double>();
      ASSERT_LT(norm(true_place - cloud.position(i)), 0.2) << name << " " << i;
    }
    total += cloud.size();
  }
  EXPECT_EQ(total, result.points);
}

TEST_P(Files, FormatsAreThoseOfTheProduct) {
  const TemporaryFolder folder;
  write_survey(options_, folder.path());
  const std::string name = tile_name(options_.product, options_.container, tile_grid(options_), 1,
                                     options_.year, "plane");
  const LasInfo info = read_las_info(folder / name);
  const bool is_old = stores_whole_degrees(options_.product, options_.container);
  EXPECT_EQ(info.version_minor, is_old ? 2 : 4);
  EXPECT_EQ(info.point_format, is_old ? 1 : 6);
  EXPECT_EQ(info.record_bytes, is_old ? 28u : 30u);
  EXPECT_EQ(info.zipped, options_.container == TileContainer::kZippedLas);
  EXPECT_EQ(info.gps_time_type, GpsTimeType::kAdjustedStandard);
  if (is_old) {
    EXPECT_TRUE(info.crs.empty());
  } else {
    EXPECT_EQ(info.crs.text(), crs_text(options_.product));
  }
  const PointCloud cloud = read_tile(folder / name);
  const Box2d tile = tile_grid(options_).tile(1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (is_old) {
      ASSERT_EQ(cloud.scan_angle_deg[i], std::round(cloud.scan_angle_deg[i]));
    }
    const double x = cloud.exact[i].x * info.scale.x + info.offset.x;
    ASSERT_GE(x, tile.min_x - 1e-6);
    ASSERT_LT(x, tile.max_x - 1e-6);
  }
}

TEST_P(Files, TheSameSeedGivesTheSameBytesWithOneAndTwoThreadsAndAnotherSeedOthers) {
  const TemporaryFolder one, two, other;
  write_survey(options_, one.path(), 1);
  write_survey(options_, two.path(), 2);
  options_.seed = 2;
  write_survey(options_, other.path(), 2);
  const auto first = contents_of(one.path()), second = contents_of(two.path()),
             third = contents_of(other.path());
  ASSERT_GE(first.size(), 4u * 4u + 4u);
  for (const auto& [name, bytes] : first) {
    ASSERT_EQ(second.count(name), 1u) << name;
    EXPECT_TRUE(second.at(name) == bytes) << name;
    const bool is_of_the_flight =
        name.find(".tif") == std::string::npos && name.find("ground.ply") == std::string::npos;
    if (is_of_the_flight) {
      EXPECT_FALSE(third.at(name) == bytes) << name;
    }
  }
  EXPECT_EQ(first.size(), second.size());
}

INSTANTIATE_TEST_SUITE_P(
    Containers, Files,
    testing::Values(
        Packing{"SwissLaz", SurveyProduct::kSwissSurface3d, TileContainer::kLaz, ""},
        Packing{"SwissZip", SurveyProduct::kSwissSurface3d, TileContainer::kZippedLas, ""},
        Packing{"SwissCopc", SurveyProduct::kSwissSurface3d, TileContainer::kCopc, ""},
        Packing{"LidarHdLaz", SurveyProduct::kLidarHd, TileContainer::kLaz, ""},
        Packing{"LidarHdCopc", SurveyProduct::kLidarHd, TileContainer::kCopc, ""},
        Packing{"LidarHdUnordered", SurveyProduct::kLidarHd, TileContainer::kLas, "unordered"}),
    [](const auto& each) { return std::string(each.param.name); });

SurveyOptions one_tile() {
  SurveyOptions options = small_survey();
  options.tiles = "1x1";
  options.product = SurveyProduct::kLidarHd;
  return options;
}

fs::path tile_of(const fs::path& folder, const SurveyOptions& options) {
  return folder / tile_name(options.product, options.container, tile_grid(options), 0, options.year,
                            "plane");
}

TEST(HeaderDefects, ALostTimeBitChangesTheHeaderOnly) {
  SurveyOptions options = one_tile();
  const TemporaryFolder clean, spoiled;
  write_survey(options, clean.path());
  options.defects = {"lost-time-bit"};
  write_survey(options, spoiled.path());
  EXPECT_EQ(read_las_info(tile_of(spoiled.path(), options)).gps_time_type,
            GpsTimeType::kWeekSeconds);
  EXPECT_EQ(read_tile(tile_of(spoiled.path(), options)).gps_time_s,
            read_tile(tile_of(clean.path(), options)).gps_time_s);
}

TEST(HeaderDefects, AHorizontalCrsHasNoHeights) {
  SurveyOptions options = one_tile();
  options.defects = {"horizontal-crs"};
  const TemporaryFolder folder;
  write_survey(options, folder.path());
  EXPECT_EQ(read_las_info(tile_of(folder.path(), options)).crs.text(), "EPSG:2154");
}

TEST(OrderDefect, UnorderedPointsAreTheSamePointsInAnotherOrder) {
  SurveyOptions options = one_tile();
  const TemporaryFolder clean, spoiled;
  write_survey(options, clean.path());
  options.defects = {"unordered"};
  write_survey(options, spoiled.path());
  PointCloud a = read_tile(tile_of(clean.path(), options));
  PointCloud b = read_tile(tile_of(spoiled.path(), options));
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(std::is_sorted(a.gps_time_s.begin(), a.gps_time_s.end() - 50));
  std::size_t backwards = 0;
  for (std::size_t i = 1; i < b.size(); ++i)
    backwards += b.gps_time_s[i] < b.gps_time_s[i - 1] ? 1 : 0;
  EXPECT_GT(backwards, b.size() / 3);
  const auto sorted = [](const PointCloud& cloud) {
    std::vector<std::array<double, 5>> rows;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      rows.push_back({cloud.gps_time_s[i], static_cast<double>(cloud.exact[i].x),
                      static_cast<double>(cloud.exact[i].y), static_cast<double>(cloud.exact[i].z),
                      static_cast<double>(cloud.intensity[i])});
    std::sort(rows.begin(), rows.end());
    return rows;
  };
  EXPECT_EQ(sorted(a), sorted(b));
}

TEST(Truth, InExtraBytesIsThatOfThePly) {
  SurveyOptions options = one_tile();
  const TemporaryFolder ply, extra;
  write_survey(options, ply.path());
  options.truth = PointTruth::kExtraBytes;
  write_survey(options, extra.path());
  const OrientedPoints truth =
      read_ply_points(tile_of(ply.path() / "truth", options).string() + ".points.ply");
  const PointCloud cloud = read_tile(tile_of(extra.path(), options));
  ASSERT_EQ(cloud.extra_stride, truth_extra_size());
  ASSERT_EQ(cloud.size(), truth.normals.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Vec3f normal;
    std::memcpy(&normal, cloud.extra_bytes.data() + i * cloud.extra_stride + 12, sizeof normal);
    ASSERT_EQ(normal, truth.normals[i]);
    std::uint16_t line = 0;
    std::memcpy(&line, cloud.extra_bytes.data() + i * cloud.extra_stride + 37, sizeof line);
    ASSERT_EQ(line, truth.line_id[i]);
  }
}

/// Rows of truth/trajectory.csv: time, recorded time, pass, x, y, z, ...
std::vector<std::array<double, 9>> read_csv(const fs::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  std::vector<std::array<double, 9>> rows;
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::array<double, 9> row{};
    for (double& field : row) fields >> field;
    rows.push_back(row);
  }
  return rows;
}

TEST(Truth, InterpolatedTrajectoryAndBeamMeetEveryPointWithinTheNoise) {
  const SurveyOptions options = one_tile();
  const TemporaryFolder folder;
  write_survey(options, folder.path());
  const auto rows = read_csv(folder / "truth/trajectory.csv");
  const PointCloud cloud = read_tile(tile_of(folder.path(), options));
  const OrientedPoints truth =
      read_ply_points(tile_of(folder.path() / "truth", options).string() + ".points.ply");
  ASSERT_EQ(truth.float_properties.size(), 3u);
  std::size_t checked = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (truth.line_id[i] == 0) continue;
    const double time = cloud.gps_time_s[i];
    const auto after = std::lower_bound(rows.begin(), rows.end(), time,
                                        [](const auto& row, double t) { return row[1] < t; });
    ASSERT_TRUE(after != rows.begin() && after != rows.end());
    const auto &a = *(after - 1), &b = *after;
    ASSERT_EQ(a[2], b[2]) << "points are measured within passes";
    const double u = (time - a[1]) / (b[1] - a[1]);
    const Vec3d sensor{a[3] + u * (b[3] - a[3]), a[4] + u * (b[4] - a[4]),
                       a[5] + u * (b[5] - a[5])};
    const Vec3d beam{truth.float_properties[0].values[i], truth.float_properties[1].values[i],
                     truth.float_properties[2].values[i]};
    const Vec3d way = cloud.position(i) - sensor;
    ASSERT_LT(norm(way - dot(way, beam) * beam), 5.0 * 0.02 + 0.01);
    ++checked;
  }
  EXPECT_GT(checked, 5000u);
}

TEST(EarlierSurvey, IsRemovedWholeAndNothingElse) {
  const TemporaryFolder folder;
  SurveyOptions options = small_survey();
  write_survey(options, folder.path());
  write_text(folder / "mine.txt", "keep");
  remove_earlier_survey(folder.path());
  const auto left = contents_of(folder.path());
  EXPECT_EQ(left.size(), 1u);
  EXPECT_EQ(left.count("mine.txt"), 1u);
}

TEST(EarlierSurvey, AListThatLeadsOutOfTheFolderIsNotFollowed) {
  const TemporaryFolder folder;
  write_text(folder / "outside.txt", "keep");
  fs::create_directories(folder / "survey/truth");
  write_text(folder / "survey/truth/survey.json",
             R"({"format": "cornice simulated survey", "files": ["../outside.txt", 7]})");
  remove_earlier_survey(folder / "survey");
  EXPECT_TRUE(fs::exists(folder / "outside.txt"));
}

}  // namespace
}  // namespace cornice::test
