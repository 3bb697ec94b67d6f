// SPDX-License-Identifier: GPL-3.0-or-later
// Windows and streams give the points of the whole file, whatever helps to find them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/base/error.h"
#include "core/io/byte_source.h"
#include "core/io/las.h"
#include "core/io/las_decode.h"
#include "tests/property/las_writer/clouds.h"
#include "tests/support/laszip_oracle.h"
#include "tests/support/small_files.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {
namespace {

const Attribute kSome = Attribute::kExact | Attribute::kGpsTime | Attribute::kClassification |
                        Attribute::kReturns | Attribute::kExtraBytes;

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same_clouds(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.size(), b.size());
  EXPECT_TRUE(same_bytes(a.positions, b.positions));
  EXPECT_TRUE(same_bytes(a.exact, b.exact));
  EXPECT_TRUE(same_bytes(a.gps_time_s, b.gps_time_s));
  EXPECT_TRUE(same_bytes(a.return_number, b.return_number));
  EXPECT_TRUE(same_bytes(a.return_count, b.return_count));
  EXPECT_TRUE(same_bytes(a.classification, b.classification));
  EXPECT_TRUE(same_bytes(a.extra_bytes, b.extra_bytes));
}

/// The points of the whole file inside the window, by brute force.
PointCloud inside(const LasInfo& info, PointCloud all, const Box2d& window) {
  std::vector<std::uint8_t> keep;
  for (const auto q : all.exact) {
    keep.push_back(
        window.contains(q.x * info.scale.x + info.offset.x, q.y * info.scale.y + info.offset.y));
  }
  all.filter(keep);
  return all;
}

/// Windows of a file: inside, across its border, a line, everything, nothing.
std::vector<Box2d> windows_of(const LasInfo& info) {
  const Box2d b = info.bounds.plan();
  const double w = b.width(), h = b.height();
  return {{b.min_x + 0.3 * w, b.min_y + 0.4 * h, b.min_x + 0.5 * w, b.min_y + 0.55 * h},
          {b.min_x - w, b.min_y - h, b.min_x + 0.1 * w, b.min_y + 0.1 * h},
          {b.max_x, b.min_y, b.max_x, b.max_y},
          b.grown(1.0),
          {b.max_x + 10.0, b.min_y, b.max_x + 20.0, b.max_y}};
}

void expect_windows_and_streams_agree(const LasInfo& info) {
  const PointCloud all = read_las(info, {.attributes = kSome}).points;
  for (const int threads : {1, 2}) {
    for (const Box2d& window : windows_of(info)) {
      LasReadOptions options{.attributes = kSome, .window = window, .threads = threads};
      const PointCloud expected = inside(info, all, window);
      expect_same_clouds(read_las(info, options).points, expected);
      PointCloud streamed;
      streamed.origin = all.origin;
      stream_las(info, options, 1000, [&](PointCloud& chunk, std::uint64_t) {
        EXPECT_FALSE(chunk.empty());
        streamed.append(chunk);
      });
      expect_same_clouds(streamed, expected);
    }
  }
}

void expect_whole_stream_agrees(const LasInfo& info, std::size_t chunk_points) {
  const PointCloud all = read_las(info, {.attributes = kSome}).points;
  for (const int threads : {1, 3}) {
    LasReadOptions options{.attributes = kSome, .threads = threads};
    PointCloud streamed;
    const LasReadResult result =
        stream_las(info, options, chunk_points, [&](PointCloud& chunk, std::uint64_t first) {
          EXPECT_EQ(first, streamed.size());
          streamed.append(chunk);
        });
    EXPECT_EQ(result.points_decoded, info.point_count);
    EXPECT_TRUE(result.points.empty());
    if (!all.empty()) expect_same_clouds(streamed, all);
  }
}

LasWriteOptions options_of(int format, bool compress) {
  LasWriteOptions options;
  options.point_format = format;
  options.version_minor = format < 6 ? 2 : 4;
  options.compress = compress;
  options.chunk_points = 500;
  options.offset = {2'746'000.0, 1'234'000.0, 0.0};
  if (format == 6) options.extra_bytes = sample_extra_bytes();
  return options;
}

class WrittenFiles : public ::testing::TestWithParam<std::tuple<int, bool, bool>> {};

TEST_P(WrittenFiles, WindowsAndStreamsAgreeWithTheWhole) {
  const auto [format, compress, index] = GetParam();
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(format, compress);
  options.spatial_index = index;
  const auto path = folder / (compress ? "a.laz" : "a.las");
  LasWriter writer(path, options);
  PointCloud cloud = sample_cloud(6789, options, 3);
  // Sorted by x, so that the index can leave out chunks.
  std::sort(cloud.exact.begin(), cloud.exact.end(),
            [](const auto& a, const auto& b) { return a.x < b.x; });
  writer.write(cloud);
  writer.close();
  EXPECT_EQ(std::filesystem::exists(folder / "a.lax"), index);
  const LasInfo info = read_las_info(path);
  EXPECT_EQ(read_las(info, {.attributes = kSome}).points.exact, cloud.exact);
  expect_windows_and_streams_agree(info);
  expect_whole_stream_agrees(info, 1700);
}
INSTANTIATE_TEST_SUITE_P(Formats, WrittenFiles,
                         ::testing::Combine(::testing::Values(1, 6), ::testing::Bool(),
                                            ::testing::Bool()));

TEST(Windows, WithAnIndexDecodeFewerPoints) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(6, true);
  options.spatial_index = true;
  PointCloud cloud = sample_cloud(20000, options, 3);
  std::sort(cloud.exact.begin(), cloud.exact.end(),
            [](const auto& a, const auto& b) { return a.x < b.x; });
  LasWriter writer(folder / "a.laz", options);
  writer.write(cloud);
  writer.close();
  const LasInfo info = read_las_info(folder / "a.laz");
  const Box2d window = windows_of(info).front();
  const LasReadResult with_index = read_las(info, {.window = window});
  EXPECT_LT(with_index.points_decoded, info.point_count / 2);
  std::filesystem::remove(folder / "a.lax");
  const LasReadResult without = read_las(info, {.window = window});
  EXPECT_EQ(without.points_decoded, info.point_count);
  expect_same_clouds(with_index.points, without.points);
}

TEST(Windows, AnIndexOlderThanItsFileIsNotTrusted) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(6, true);
  options.spatial_index = true;
  LasWriter writer(folder / "a.laz", options);
  writer.write(sample_cloud(5000, options, 3));
  writer.close();
  const auto written = std::filesystem::last_write_time(folder / "a.laz");
  std::filesystem::last_write_time(folder / "a.lax", written - std::chrono::hours(1));
  const LasInfo info = read_las_info(folder / "a.laz");
  EXPECT_EQ(read_las(info, {.window = windows_of(info).front()}).points_decoded, 5000u);
}

TEST(Windows, OfCopcFilesAgreeWithTheWholeAndDecodeLess) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(6, true);
  const auto path = folder / "a.copc.laz";
  write_copc(path, sample_cloud(20000, options, 3), options);
  const LasInfo info = read_las_info(path);
  EXPECT_EQ(info.container, LasContainer::kCopc);
  expect_windows_and_streams_agree(info);
  expect_whole_stream_agrees(info, 1700);
}

TEST(Windows, OfACopcFileWithADamagedHierarchyStillGiveAllPoints) {
  const TemporaryFolder folder;
  const auto path = folder / "a.copc.laz";
  LasWriteOptions options = options_of(6, true);
  write_copc(path, sample_cloud(5000, options, 3), options);
  const Bytes bytes = read_file(path);
  // The info record is the first: its data at byte 429 places the octree and its root page.
  constexpr std::size_t kCenterX = 429, kHalfSize = 453, kRootOffset = 469, kRootBytes = 477;
  for (const Bytes& bad :
       {patched(bytes, kHalfSize, std::nan("")), patched(bytes, kCenterX, INFINITY + 0.0),
        patched<std::uint64_t>(bytes, kRootOffset, ~0ull - 7),
        patched<std::uint64_t>(bytes, kRootOffset, 0),
        patched<std::uint64_t>(bytes, kRootBytes, ~0ull / 2)}) {
    write_file(path, bad);
    expect_windows_and_streams_agree(read_las_info(path));
  }
}

TEST(Streams, OfOneUncutStreamComeInPieces) {
  const auto path = std::filesystem::path(CORNICE_TEST_DATA) / "robustness" /
                    "pdal_simple-laszip-compressor-version-1.2r0.laz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no file " << path;
  const LasInfo info = read_las_info(path);
  expect_whole_stream_agrees(info, 100);
  expect_windows_and_streams_agree(info);
}

TEST(Streams, NeverHoldMoreThanAFewChunks) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(6, true);
  LasWriter writer(folder / "a.laz", options);
  writer.write(sample_cloud(20000, options, 3));
  writer.close();
  std::size_t most = 0;
  std::size_t calls = 0;
  stream_las(read_las_info(folder / "a.laz"), {.attributes = kSome}, 2000,
             [&](PointCloud& chunk, std::uint64_t) {
               most = std::max(most, chunk.size());
               ++calls;
             });
  EXPECT_EQ(most, 2000u);
  EXPECT_EQ(calls, 10u);
}

TEST(Streams, AnErrorInTheSinkComesThrough) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(1, true);
  LasWriter writer(folder / "a.laz", options);
  writer.write(sample_cloud(9000, options, 3));
  writer.close();
  const LasInfo info = read_las_info(folder / "a.laz");
  for (const int threads : {1, 2}) {
    EXPECT_THROW(stream_las(info, {.threads = threads}, 1000,
                            [](PointCloud&, std::uint64_t) { throw RunError("disk", "full"); }),
                 RunError);
  }
}

/// Stops after some points.
class Impatient : public Progress {
 public:
  void advance(std::uint64_t work) override { done += work; }
  bool cancelled() const override { return done > 1000; }
  std::uint64_t done = 0;
};

TEST(Reading, StopsWhereTheCallerWantsItTo) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(6, true);
  LasWriter writer(folder / "a.laz", options);
  writer.write(sample_cloud(20000, options, 3));
  writer.close();
  for (const int threads : {1, 2}) {
    Impatient progress;
    EXPECT_THROW(read_las(read_las_info(folder / "a.laz"), {.threads = threads}, progress),
                 Cancelled);
    EXPECT_LT(progress.done, 20000u);
  }
}

class AllFormats : public ::testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(AllFormats, EveryAttributeOfAWrittenFileComesBack) {
  const auto [format, compress] = GetParam();
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(format, compress);
  options.version_minor = format < 4 ? 2 : format < 6 ? 3 : 4;
  options.extra_bytes = sample_extra_bytes();
  if (options.version_minor < 4) options.version_minor = 4;  // where extra bytes are described
  const auto path = folder / (compress ? "a.laz" : "a.las");
  const PointCloud cloud = sample_cloud(1234, options, 11);
  LasWriter writer(path, options);
  writer.write(cloud);
  writer.close();
  const LasInfo info = read_las_info(path);
  const OracleCloud oracle = read_all_with_laszip(path);
  ASSERT_EQ(oracle.problem, "");
  ASSERT_EQ(info.extra_bytes.size(), 3u);
  EXPECT_EQ(info.extra_bytes[1].name, "amplitude");
  EXPECT_EQ(info.extra_bytes[1].offset, 4u);
  EXPECT_EQ(info.extra_bytes[1].no_data, -1.0);
  EXPECT_EQ(info.extra_bytes[0].scale, 0.01);
  for (const int threads : {1, 2}) {
    const PointCloud read =
        read_las(info, {.attributes = Attribute::kAll, .threads = threads}).points;
    const PointCloud& expected = oracle.points;
    EXPECT_EQ(read.exact, cloud.exact);
    EXPECT_EQ(read.exact, expected.exact);
    EXPECT_EQ(read.gps_time_s, expected.gps_time_s);
    EXPECT_EQ(read.scan_angle_deg, expected.scan_angle_deg);
    EXPECT_EQ(read.return_number, expected.return_number);
    EXPECT_EQ(read.return_count, expected.return_count);
    EXPECT_EQ(read.classification, expected.classification);
    EXPECT_EQ(read.flags, expected.flags);
    EXPECT_EQ(read.point_source_id, expected.point_source_id);
    EXPECT_EQ(read.scanner_channel, expected.scanner_channel);
    EXPECT_EQ(read.user_data, expected.user_data);
    EXPECT_EQ(read.intensity, expected.intensity);
    EXPECT_TRUE(read.rgb.empty() || read.rgb == expected.rgb);
    EXPECT_TRUE(read.nir.empty() || read.nir == expected.nir);
    EXPECT_TRUE(read.wave_packet.empty() || read.wave_packet == expected.wave_packet);
    EXPECT_EQ(read.extra_bytes, expected.extra_bytes);
    const bool color =
        format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
    EXPECT_EQ(read.rgb.empty(), !color);
    EXPECT_EQ(read.nir.empty(), format != 8 && format != 10);
    EXPECT_EQ(read.wave_packet.empty(), format != 4 && format != 5 && format != 9 && format != 10);
  }
}
INSTANTIATE_TEST_SUITE_P(Formats, AllFormats,
                         ::testing::Combine(::testing::Range(0, 11), ::testing::Bool()));

TEST(Attributes, ThatAreNotAskedForStayEmptyAndTheOthersAreTheSame) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(7, true);
  LasWriter writer(folder / "a.laz", options);
  writer.write(sample_cloud(3000, options, 11));
  writer.close();
  const LasInfo info = read_las_info(folder / "a.laz");
  const PointCloud all = read_las(info, {.attributes = Attribute::kAll}).points;
  for (std::uint32_t bit = 1; bit <= static_cast<std::uint32_t>(Attribute::kWaveform); bit <<= 1) {
    const PointCloud one = read_las(info, {.attributes = static_cast<Attribute>(bit)}).points;
    EXPECT_EQ(one.positions, all.positions);
    const auto same_or_empty = [&](const auto& array, const auto& whole, Attribute attribute) {
      if (bit == static_cast<std::uint32_t>(attribute)) {
        EXPECT_EQ(array, whole) << bit;
      } else {
        EXPECT_TRUE(array.empty()) << bit;
      }
    };
    same_or_empty(one.exact, all.exact, Attribute::kExact);
    same_or_empty(one.gps_time_s, all.gps_time_s, Attribute::kGpsTime);
    same_or_empty(one.scan_angle_deg, all.scan_angle_deg, Attribute::kScanAngle);
    same_or_empty(one.return_number, all.return_number, Attribute::kReturns);
    same_or_empty(one.return_count, all.return_count, Attribute::kReturns);
    same_or_empty(one.classification, all.classification, Attribute::kClassification);
    same_or_empty(one.flags, all.flags, Attribute::kFlags);
    same_or_empty(one.point_source_id, all.point_source_id, Attribute::kPointSource);
    same_or_empty(one.scanner_channel, all.scanner_channel, Attribute::kChannel);
    same_or_empty(one.user_data, all.user_data, Attribute::kUserData);
    same_or_empty(one.intensity, all.intensity, Attribute::kIntensity);
    same_or_empty(one.rgb, all.rgb, Attribute::kColor);
  }
}

TEST(Origin, IsTheFloorOfTheHeadersMinimumUnlessGiven) {
  const TemporaryFolder folder;
  LasWriteOptions options = options_of(1, true);
  LasWriter writer(folder / "a.laz", options);
  writer.write(sample_cloud(100, options, 11));
  writer.close();
  const LasInfo info = read_las_info(folder / "a.laz");
  const Vec3d floor{std::floor(info.bounds.min.x), std::floor(info.bounds.min.y),
                    std::floor(info.bounds.min.z)};
  EXPECT_EQ(read_las(info, {}).points.origin, floor);
  const Vec3d mine{2'745'000.5, 1'233'000.0, -100.0};
  const PointCloud moved = read_las(info, {.attributes = Attribute::kExact, .origin = mine}).points;
  EXPECT_EQ(moved.origin, mine);
  EXPECT_NEAR(moved.position(7).x, moved.exact[7].x * 0.01 + 2'746'000.0, 1e-3);
}

}  // namespace
}  // namespace cornice::test
