// SPDX-License-Identifier: GPL-3.0-or-later
// Our reading of real files against LASzip's own sequential reading.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/base/error.h"
#include "core/io/las.h"
#include "tests/support/laszip_oracle.h"

namespace cornice::test {
namespace {

/// Empty where both arrays hold the same bytes (so that NaN equals NaN), else what differs.
template <class T>
void expect_same_bytes(const std::vector<T>& ours, const std::vector<T>& theirs, const char* what) {
  ASSERT_EQ(ours.size(), theirs.size()) << what;
  if (ours.empty()) return;
  EXPECT_EQ(std::memcmp(ours.data(), theirs.data(), ours.size() * sizeof(T)), 0) << what;
}

void expect_same_points(const LasInfo& info, const PointCloud& ours, const PointCloud& theirs) {
  expect_same_bytes(ours.exact, theirs.exact, "exact");
  expect_same_bytes(ours.gps_time_s, theirs.gps_time_s, "gps_time_s");
  expect_same_bytes(ours.scan_angle_deg, theirs.scan_angle_deg, "scan_angle_deg");
  expect_same_bytes(ours.return_number, theirs.return_number, "return_number");
  expect_same_bytes(ours.return_count, theirs.return_count, "return_count");
  expect_same_bytes(ours.classification, theirs.classification, "classification");
  expect_same_bytes(ours.flags, theirs.flags, "flags");
  expect_same_bytes(ours.point_source_id, theirs.point_source_id, "point_source_id");
  expect_same_bytes(ours.scanner_channel, theirs.scanner_channel, "scanner_channel");
  expect_same_bytes(ours.user_data, theirs.user_data, "user_data");
  expect_same_bytes(ours.intensity, theirs.intensity, "intensity");
  if (!ours.rgb.empty()) expect_same_bytes(ours.rgb, theirs.rgb, "rgb");
  if (!ours.nir.empty()) expect_same_bytes(ours.nir, theirs.nir, "nir");
  if (!ours.wave_packet.empty()) expect_same_bytes(ours.wave_packet, theirs.wave_packet, "waves");
  EXPECT_EQ(info.extra_stride, theirs.extra_stride);
  expect_same_bytes(ours.extra_bytes, theirs.extra_bytes, "extra_bytes");
  ASSERT_EQ(ours.positions.size(), ours.exact.size());
  for (std::size_t i = 0; i < ours.size(); i += 1 + ours.size() / 1000) {
    const auto q = ours.exact[i];
    EXPECT_EQ(ours.positions[i].x,
              static_cast<float>(q.x * info.scale.x + info.offset.x - ours.origin.x));
    EXPECT_EQ(ours.positions[i].z,
              static_cast<float>(q.z * info.scale.z + info.offset.z - ours.origin.z));
  }
}

std::vector<std::filesystem::path> real_files() { return point_files_below(CORNICE_TEST_DATA); }

TEST(RealFiles, EveryFileThatLaszipReadsGivesTheSameBytesWithOneTwoAndThreeThreads) {
  const auto files = real_files();
  if (files.empty()) GTEST_SKIP() << "no point files below " << CORNICE_TEST_DATA;
  int compared = 0;
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    const OracleCloud oracle = read_all_with_laszip(file);
    try {
      const LasInfo info = read_las_info(file, {.crs_override = "EPSG:2154"});
      // Every file with two threads, all but the largest with one and three as well.
      const bool is_large = info.point_count > 200'000;
      for (const int threads : is_large ? std::vector{2} : std::vector{1, 2, 3}) {
        LasReadOptions options{.attributes = Attribute::kAll, .threads = threads};
        options.keep_readable_part = true;
        const LasReadResult result = read_las(info, options);
        EXPECT_EQ(result.problem.empty(), oracle.problem.empty()) << result.problem;
        if (oracle.points.exact.empty() && !oracle.problem.empty()) continue;
        expect_same_points(info, result.points, oracle.points);
        ++compared;
      }
    } catch (const InputError& error) {
      std::printf("%s\n", error.what());
      EXPECT_NE(oracle.problem, "") << error.what();
    }
  }
  std::printf("%d reads compared of %zu files\n", compared, files.size());
  EXPECT_GE(compared, 3);
}

}  // namespace
}  // namespace cornice::test
