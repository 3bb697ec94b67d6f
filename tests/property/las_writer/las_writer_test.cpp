// SPDX-License-Identifier: GPL-3.0-or-later
// What LasWriter writes, as LASzip reads it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/io/las.h"
#include "tests/property/las_writer/clouds.h"
#include "tests/property/las_writer/laszip_oracle.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::expected_points;
using test::OracleFile;
using test::read_with_laszip;
using test::sample_cloud;
using test::sample_extra_bytes;
using test::TemporaryFolder;

constexpr std::array<int, 5> kHighestFormat = {1, 1, 3, 5, 10};

LasWriteOptions options_of(int version_minor, int point_format) {
  LasWriteOptions options;
  options.version_minor = version_minor;
  options.point_format = point_format;
  options.offset = {2746000.0, 1234000.0, 500.0};
  return options;
}

void write_cloud(const std::filesystem::path& path, const PointCloud& cloud,
                 const LasWriteOptions& options) {
  LasWriter writer(path, options);
  writer.write(cloud);
  writer.close();
}

/// The file's header says what its points say.
void expect_true_header(const OracleFile& file, const LasWriteOptions& options) {
  std::array<std::uint64_t, 16> by_return{};
  std::array<double, 6> bounds = {HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const test::OraclePoint& p : file.points) {
    ++by_return[static_cast<std::size_t>(p.return_number)];
    const std::array<double, 3> at = {p.x * options.scale.x + options.offset.x,
                                      p.y * options.scale.y + options.offset.y,
                                      p.z * options.scale.z + options.offset.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds[2 * axis] = std::min(bounds[2 * axis], at[axis]);
      bounds[2 * axis + 1] = std::max(bounds[2 * axis + 1], at[axis]);
    }
  }
  EXPECT_EQ(file.bounds, bounds);
  const bool has_legacy = options.point_format < 6;
  EXPECT_EQ(file.legacy_count, has_legacy ? file.points.size() : 0u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(file.legacy_by_return[i], has_legacy ? by_return[i + 1] : 0u);
  }
  if (options.version_minor < 4) return;
  EXPECT_EQ(file.extended_count, file.points.size());
  for (std::size_t i = 0; i < 15; ++i) EXPECT_EQ(file.extended_by_return[i], by_return[i + 1]);
}

/// Our own reader finds the same points, and what the header promises of them.
void expect_same_through_our_reader(const std::filesystem::path& path, const PointCloud& cloud,
                                    const LasWriteOptions& options) {
  const LasInfo info = read_las_info(path);
  LasReadOptions read;
  read.attributes = Attribute::kAll;
  read.threads = 2;
  const LasReadResult result = read_las(info, read);
  EXPECT_EQ(expected_points(result.points, options), expected_points(cloud, options));
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
  EXPECT_EQ(info.extra_bytes.size(), options.extra_bytes.size());
  for (std::size_t i = 0; i < info.extra_bytes.size(); ++i) {
    EXPECT_EQ(info.extra_bytes[i].name, options.extra_bytes[i].name);
    EXPECT_EQ(info.extra_bytes[i].data_type, options.extra_bytes[i].data_type);
    EXPECT_EQ(info.extra_bytes[i].size, options.extra_bytes[i].size);
    EXPECT_EQ(info.extra_bytes[i].scale, options.extra_bytes[i].scale);
    EXPECT_EQ(info.extra_bytes[i].offset_value, options.extra_bytes[i].offset_value);
    EXPECT_EQ(info.extra_bytes[i].no_data, options.extra_bytes[i].no_data);
  }
}

struct Setting {
  int version_minor;
  int point_format;
  bool compress;
  bool extra_bytes;
};

std::vector<Setting> every_setting() {
  std::vector<Setting> settings;
  for (int version = 0; version <= 4; ++version) {
    for (int format = 0; format <= kHighestFormat[static_cast<std::size_t>(version)]; ++format) {
      for (bool compress : {false, true}) {
        for (bool extra : {false, true}) settings.push_back({version, format, compress, extra});
      }
    }
  }
  return settings;
}

class EverySetting : public testing::TestWithParam<Setting> {};

TEST_P(EverySetting, IsReadBackByLaszipPointForPoint) {
  const Setting setting = GetParam();
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(setting.version_minor, setting.point_format);
  options.compress = setting.compress;
  if (setting.extra_bytes) options.extra_bytes = sample_extra_bytes();
  for (const std::uint32_t chunk : {7u, 100u, 50000u}) {
    options.chunk_points = chunk;
    const PointCloud cloud = sample_cloud(300, options, chunk);
    const auto path = folder / (setting.compress ? "points.laz" : "points.las");
    write_cloud(path, cloud, options);
    const OracleFile file = read_with_laszip(path);
    EXPECT_EQ(file.version_minor, setting.version_minor);
    EXPECT_EQ(file.point_format, setting.point_format);
    EXPECT_EQ(file.compressed, setting.compress);
    ASSERT_EQ(file.points, expected_points(cloud, options)) << "chunks of " << chunk;
    expect_true_header(file, options);
    expect_same_through_our_reader(path, cloud, options);
  }
}

INSTANTIATE_TEST_SUITE_P(LasWriter, EverySetting, testing::ValuesIn(every_setting()),
                         [](const auto& instance) {
                           const Setting& s = instance.param;
                           return "Las1" + std::to_string(s.version_minor) + "Format" +
                                  std::to_string(s.point_format) + (s.compress ? "Laz" : "Las") +
                                  (s.extra_bytes ? "WithExtraBytes" : "");
                         });

TEST(LasWriter, WritesAFileWithoutPoints) {
  const TemporaryFolder folder;
  for (const int format : {1, 6}) {
    for (const bool compress : {false, true}) {
      LasWriteOptions options = options_of(4, format);
      options.compress = compress;
      write_cloud(folder / "empty.laz", {}, options);
      const OracleFile file = read_with_laszip(folder / "empty.laz");
      EXPECT_TRUE(file.points.empty());
      EXPECT_EQ(file.bounds, (std::array<double, 6>{}));
    }
  }
}

TEST(LasWriter, GivesTheSameBytesHoweverThePointsAreHandedOver) {
  const TemporaryFolder folder;
  const LasWriteOptions options = options_of(4, 6);
  PointCloud cloud;
  const PointCloud full = sample_cloud(1000, options, 1);
  cloud.origin = full.origin;
  cloud.positions = full.positions;
  cloud.gps_time_s = full.gps_time_s;
  write_cloud(folder / "once.laz", cloud, options);
  LasWriter writer(folder / "parts.laz", options);
  for (const auto& [begin, end] : {std::pair{0, 333}, std::pair{333, 333}, std::pair{333, 1000}}) {
    PointCloud piece;
    piece.origin = cloud.origin;
    piece.positions.assign(cloud.positions.begin() + begin, cloud.positions.begin() + end);
    piece.gps_time_s.assign(cloud.gps_time_s.begin() + begin, cloud.gps_time_s.begin() + end);
    writer.write(piece);
  }
  EXPECT_EQ(writer.points_written(), 1000u);
  writer.close();
  EXPECT_EQ(test::read_text(folder / "once.laz"), test::read_text(folder / "parts.laz"));
}

TEST(LasWriter, RoundsPositionsToTheStoredStepWhereNoIntegersAreGiven) {
  const TemporaryFolder folder;
  const LasWriteOptions options = options_of(4, 6);
  PointCloud cloud;
  cloud.origin = {2746100.0, 1234100.0, 600.0};
  cloud.positions = {{0.004f, 0.006f, -0.016f}, {-150.0f, 0.0f, 899.99f}};
  write_cloud(folder / "p.las", cloud, options);
  const OracleFile file = read_with_laszip(folder / "p.las");
  ASSERT_EQ(file.points.size(), 2u);
  EXPECT_EQ(file.points[0].x, 10000);
  EXPECT_EQ(file.points[0].y, 10001);
  EXPECT_EQ(file.points[0].z, 9998);
  EXPECT_EQ(file.points[1].x, -5000);
  EXPECT_EQ(file.points[1].z, 99999);
  EXPECT_EQ(file.points[0].return_number, 1);
  EXPECT_EQ(file.points[0].return_count, 1);
  EXPECT_EQ(file.points[0].gps_time, 0.0);
}

TEST(LasWriter, RoundsScanAnglesToTheUnitOfTheFormat) {
  const TemporaryFolder folder;
  for (const int format : {1, 6}) {
    PointCloud cloud;
    cloud.positions.resize(4);
    cloud.scan_angle_deg = {-15.49f, 15.51f, 0.0089f, -0.4f};
    LasWriteOptions options = options_of(4, format);
    options.offset = {};
    write_cloud(folder / "p.laz", cloud, options);
    std::vector<int> angles;
    for (const auto& p : read_with_laszip(folder / "p.laz").points) angles.push_back(p.scan_angle);
    if (format == 1) {
      EXPECT_THAT(angles, testing::ElementsAre(-15, 16, 0, 0));
    } else {
      EXPECT_THAT(angles, testing::ElementsAre(-2582, 2585, 1, -67));
    }
  }
}

TEST(LasWriter, SaysTheGpsTimeTypeAndWktInTheGlobalEncoding) {
  const TemporaryFolder folder;
  const auto encoding = [&](int version, int format, GpsTimeType type, bool with_crs) {
    LasWriteOptions options = options_of(version, format);
    options.gps_time_type = type;
    if (with_crs) options.crs = crs_from_text("EPSG:2056+5728");
    write_cloud(folder / "p.laz", {}, options);
    return read_with_laszip(folder / "p.laz").global_encoding;
  };
  EXPECT_EQ(encoding(2, 1, GpsTimeType::kAdjustedStandard, true), 1);
  EXPECT_EQ(encoding(2, 1, GpsTimeType::kWeekSeconds, true), 0);
  EXPECT_EQ(encoding(2, 0, GpsTimeType::kAdjustedStandard, false), 0);
  EXPECT_EQ(encoding(1, 1, GpsTimeType::kAdjustedStandard, false), 0);
  EXPECT_EQ(encoding(4, 1, GpsTimeType::kAdjustedStandard, true), 17);
  EXPECT_EQ(encoding(4, 1, GpsTimeType::kAdjustedStandard, false), 1);
  EXPECT_EQ(encoding(4, 6, GpsTimeType::kWeekSeconds, false), 16);
}

TEST(LasWriter, WritesTheCrsAsWktOrAsKeysThatGiveItBack) {
  const TemporaryFolder folder;
  for (const char* text : {"EPSG:2056+5728", "EPSG:2154+5720"}) {
    for (const int version : {0, 2, 3, 4}) {
      LasWriteOptions options = options_of(version, 1);
      options.crs = crs_from_text(text);
      write_cloud(folder / "p.laz", {}, options);
      const OracleFile file = read_with_laszip(folder / "p.laz");
      ASSERT_FALSE(file.vlrs.empty());
      const test::OracleVlr& record = file.vlrs.front();
      EXPECT_EQ(record.user_id, "LASF_Projection");
      const auto crs = version == 4 ? crs_from_wkt({record.data.begin(), record.data.end()})
                                    : crs_from_geotiff_keys(record.data, {}, "");
      EXPECT_EQ(record.record_id, version == 4 ? 2112 : 34735);
      ASSERT_TRUE(crs);
      EXPECT_EQ(crs->text(), text);
    }
  }
}

TEST(LasWriter, PassesRecordsOnAndLeavesOutThoseItMakesItself) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(4, 6);
  options.crs = crs_from_text("EPSG:2154");
  options.vlrs = {{"cornice", 7, "note", {1, 2, 3}, false},
                  {"LASF_Projection", 2112, "old", {'x'}, false},
                  {"laszip encoded", 22204, "old", {1}, false},
                  {"copc", 1, "old", std::vector<std::uint8_t>(160), false},
                  {"LASF_Spec", 4, "old", {1}, false},
                  {"cornice", 8, "long note", std::vector<std::uint8_t>(70000, 5), true}};
  const PointCloud cloud = sample_cloud(100, options, 3);
  write_cloud(folder / "p.laz", cloud, options);
  const OracleFile file = read_with_laszip(folder / "p.laz");
  EXPECT_EQ(file.points, expected_points(cloud, options));
  std::vector<std::string> ids;
  for (const auto& vlr : file.vlrs) ids.push_back(vlr.user_id + std::to_string(vlr.record_id));
  // LASzip keeps its own record to itself.
  EXPECT_THAT(ids, testing::ElementsAre("LASF_Projection2112", "cornice7"));
  // The extended record stands at the end of the file, where the header says.
  const std::string bytes = test::read_text(folder / "p.laz");
  std::uint64_t at = 0;
  std::memcpy(&at, &bytes[235], 8);
  ASSERT_EQ(at + 60 + 70000, bytes.size());
  EXPECT_EQ(bytes.substr(at + 2, 7), "cornice");
  EXPECT_EQ(bytes.substr(at + 60), std::string(70000, '\5'));
}

TEST(LasWriter, RefusesOptionsThatNoFileCanHave) {
  const TemporaryFolder folder;
  const auto refused = [&](const auto& change) {
    LasWriteOptions options = options_of(4, 6);
    change(options);
    EXPECT_THROW(LasWriter(folder / "p.laz", options), UsageError);
    EXPECT_TRUE(folder.entries().empty());
  };
  refused([](auto& o) { o.version_minor = 5; });
  refused([](auto& o) { o.version_minor = -1; });
  refused([](auto& o) { o.version_minor = 2; });
  refused([](auto& o) { o.point_format = 11; });
  refused([](auto& o) { o.point_format = -1; });
  refused([](auto& o) { o.scale.x = 0.0; });
  refused([](auto& o) { o.scale.y = -0.01; });
  refused([](auto& o) { o.scale.z = std::numeric_limits<double>::quiet_NaN(); });
  refused([](auto& o) { o.offset.z = std::numeric_limits<double>::infinity(); });
  refused([](auto& o) { o.chunk_points = 0; });
  refused([](auto& o) { o.extra_bytes = {{"bad", "", 31, 0, 0, 1.0, 0.0, {}}}; });
  refused([](auto& o) { o.extra_bytes = {{"none", "", 0, 0, 0, 1.0, 0.0, {}}}; });
  refused([](auto& o) { o.extra_bytes = {{"size", "", 3, 0, 4, 1.0, 0.0, {}}}; });
  refused([](auto& o) {
    o.version_minor = 2;
    o.point_format = 1;
    o.vlrs = {{"long", 1, "", std::vector<std::uint8_t>(65536), false}};
  });
}

TEST(LasWriter, RefusesValuesThatDoNotFitAndLeavesNoFile) {
  const TemporaryFolder folder;
  const auto refused = [&](int format, const auto& change) {
    LasWriteOptions options = options_of(4, format);
    options.offset = {};
    PointCloud cloud;
    cloud.positions.resize(3);
    change(cloud);
    {
      LasWriter writer(folder / "p.laz", options);
      try {
        writer.write(cloud);
        ADD_FAILURE() << "format " << format << " took it";
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("p.laz"));
        EXPECT_THAT(error.what(), testing::HasSubstr("point 1"));
      }
    }
    EXPECT_TRUE(folder.entries().empty());
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  refused(6, [&](PointCloud& c) { c.positions[1].x = nan; });
  refused(6, [&](PointCloud& c) { c.positions[1].y = std::numeric_limits<float>::infinity(); });
  refused(6, [](PointCloud& c) { c.positions[1].z = 3e7f; });
  refused(6, [](PointCloud& c) { c.positions[1].z = -3e7f; });
  refused(6, [&](PointCloud& c) { c.scan_angle_deg = {0.0f, nan, 0.0f}; });
  refused(6, [](PointCloud& c) { c.scan_angle_deg = {0.0f, 197.0f, 0.0f}; });
  refused(1, [](PointCloud& c) { c.scan_angle_deg = {0.0f, 128.0f, 0.0f}; });
  refused(1, [](PointCloud& c) { c.classification = {0, 66, 0}; });
  refused(1, [](PointCloud& c) { c.return_number = {1, 8, 1}; });
  refused(6, [](PointCloud& c) { c.return_number = {1, 16, 1}; });
  refused(6, [](PointCloud& c) { c.scanner_channel = {0, 4, 0}; });
}

struct IndexCase {
  const char* name;
  Vec3d offset;
  Vec3d scale;
  double side;
  const char* crs;
};

class SpatialIndex : public testing::TestWithParam<IndexCase> {};

TEST_P(SpatialIndex, LeadsLaszipToExactlyThePointsInside) {
  const IndexCase& parameter = GetParam();
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(4, 6);
  options.offset = parameter.offset;
  options.scale = parameter.scale;
  options.crs = crs_from_text(parameter.crs);
  options.spatial_index = true;
  options.chunk_points = 500;
  PointCloud cloud = sample_cloud(5000, options, 5, parameter.side);
  // Some points exactly on the cell borders.
  for (std::size_t i = 0; i < 2000; ++i) {
    auto& p = cloud.exact[i];
    p.x = static_cast<std::int32_t>(
        std::lround(std::floor(p.x * options.scale.x / 8.0) * 8.0 / options.scale.x));
  }
  write_cloud(folder / "p.laz", cloud, options);
  EXPECT_THAT(folder.entries(), testing::ElementsAre("p.lax", "p.laz"));
  const std::vector<test::OraclePoint> all = expected_points(cloud, options);
  for (int i = 0; i < 12; ++i) {
    CounterRandom random(9, 0, static_cast<std::uint64_t>(i));
    const double x = parameter.offset.x + parameter.side * random.uniform(-0.1, 0.9);
    const double y = parameter.offset.y + parameter.side * random.uniform(-0.1, 0.9);
    const double width = parameter.side * random.uniform(0.0, 0.3);
    std::vector<test::OraclePoint> inside;
    for (const test::OraclePoint& p : all) {
      const double px = p.x * options.scale.x + options.offset.x;
      const double py = p.y * options.scale.y + options.offset.y;
      if (px >= x && px < x + width && py >= y && py < y + width) inside.push_back(p);
    }
    const auto found =
        test::read_window_with_laszip(folder / "p.laz", {x, y, x + width, y + width});
    ASSERT_EQ(found, inside) << "window " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(
    LasWriter, SpatialIndex,
    testing::Values(
        IndexCase{"Metres", {2746000, 1234000, 0}, {0.01, 0.01, 0.01}, 1000.0, "EPSG:2056"},
        IndexCase{"OneCell", {-3, -5, 0}, {0.001, 0.001, 0.001}, 2.0, "EPSG:2056"},
        IndexCase{"AcrossZero", {-400, -300, 0}, {0.01, 0.01, 0.01}, 700.0, "EPSG:2056"},
        IndexCase{"Degrees", {7.1, 46.2, 0}, {1e-7, 1e-7, 0.01}, 0.02, "EPSG:4326"},
        IndexCase{"WiderThanTheTree", {0, 0, 0}, {1.0, 1.0, 1.0}, 2e6, "EPSG:2056"}),
    [](const auto& instance) { return std::string(instance.param.name); });

TEST(LasWriter, RemovesTheIndexOfAFileItReplaces) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(4, 6);
  options.spatial_index = true;
  write_cloud(folder / "p.laz", sample_cloud(100, options, 1), options);
  ASSERT_TRUE(std::filesystem::exists(folder / "p.lax"));
  options.spatial_index = false;
  write_cloud(folder / "p.laz", sample_cloud(100, options, 2), options);
  EXPECT_THAT(folder.entries(), testing::ElementsAre("p.laz"));
}

TEST(LasWriter, LeavesNothingWhereItIsNotClosed) {
  const TemporaryFolder folder;
  {
    const LasWriteOptions options = options_of(4, 6);
    LasWriter writer(folder / "p.laz", options);
    writer.write(sample_cloud(100, options, 1));
    EXPECT_FALSE(std::filesystem::exists(folder / "p.laz"));
  }
  EXPECT_TRUE(folder.entries().empty());
}

/// A limit on the size of files stands in for a full disk: both make write() fail.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST(LasWriter, SaysThatTheDiskIsFullAndLeavesNoFile) {
  for (const bool compress : {false, true}) {
    // Small enough to stay in the writer's buffer until close(), and larger.
    for (const std::size_t count : {10000u, 100000u}) {
      const TemporaryFolder folder;
      LasWriteOptions options = options_of(4, 6);
      options.compress = compress;
      const PointCloud cloud = sample_cloud(count, options, 1);
      const SmallDisk disk(40000);
      try {
        write_cloud(folder / "p.laz", cloud, options);
        ADD_FAILURE() << "written to a full disk";
      } catch (const RunError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("p.laz: cannot be written"));
        EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
      }
      EXPECT_TRUE(folder.entries().empty());
    }
  }
}

}  // namespace
}  // namespace cornice
