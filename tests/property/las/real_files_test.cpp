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

/// What becomes of a file: "points" of how many, or the error or problem.
std::string outcome(const std::filesystem::path& file) {
  try {
    const LasInfo info = read_las_info(file);
    LasReadOptions options{.attributes = Attribute::kAll};
    options.keep_readable_part = true;
    const LasReadResult result = read_las(info, options);
    const std::string count = std::to_string(result.points.size());
    return result.problem.empty() ? count + " points" : count + " points, " + result.problem;
  } catch (const InputError& error) {
    EXPECT_EQ(error.subject(), file.string());
    EXPECT_THAT(error.problem(), ::testing::HasSubstr("; ")) << "no remedy";
    EXPECT_THAT(error.problem(), ::testing::Not(::testing::HasSubstr("\n")));
    return error.problem();
  }
}

TEST(RealFiles, EachBadOneGivesWhatItCanOrEndsInItsOneClearLine) {
  const std::filesystem::path folder = std::filesystem::path(CORNICE_TEST_DATA) / "robustness";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no folder " << folder;
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"derived_header_only_100_bytes.las", "ends inside the header, after 100 of 227 bytes"},
      {"derived_truncated_60pct_bcts_4.laz", "358286 points, is cut short: its chunk table"},
      {"derived_truncated_midrecord_autzen_trim.las", "29351 points, is cut short"},
      {"derived_zero_bytes.laz", "is empty"},
      {"git_lfs_pointer_red-rocks.laz", "git-lfs pointer"},
      {"ign_Semis_2022_0906_6665_LA93_IGN69_nok.laz", "its writer did not finish"},
      {"ign_test_pdalfail_0643_6319_LA93_IGN69.laz", "EPSG:65535"},
      {"lasR_las14_pdrf6.laz", "coordinate system that cannot be read"},
      {"lasR_malformed_extrabytes.las", "10 points"},
      {"pdal_bad_vlr_count.las", "10 points"},
      {"pdal_garbage_nVariableLength.las", "718 points, is cut short"},
      {"pdal_gps-time-nan.las", "1 points"},
      {"pdal_laszip-generated_with2bytespadding.laz", "1065 points"},
      {"pdal_lots_of_vlr.las", "1 points"},
      {"pdal_no-points.las", "0 points"},
      {"pdal_permutations_1.2-no-points.las", "0 points, is cut short"},
      {"pdal_simple-laszip-compressor-version-1.2r0.laz", "1065 points"}};
  for (const auto& [name, words] : expected) {
    if (!std::filesystem::exists(folder / name)) continue;
    EXPECT_THAT(outcome(folder / name), ::testing::HasSubstr(words)) << name;
  }
  for (const auto& file : point_files_below(folder)) EXPECT_NE(outcome(file), "") << file;
}

}  // namespace
}  // namespace cornice::test
