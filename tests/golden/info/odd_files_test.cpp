// SPDX-License-Identifier: GPL-3.0-or-later
// Damaged and odd files: what is found in each, or the line that says why nothing can be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.h"
#include "stages/info/examine.h"

namespace cornice::info {
namespace {

struct Odd {
  std::string file;
  std::int64_t points;               // -1: nothing can be said
  std::vector<std::string> defects;  // ids, all of them
  std::string error;                 // part of the line
};

// clang-format off
const Odd kOdd[] = {
    {"derived_header_only_100_bytes.las", -1, {}, "ends inside the header"},
    {"derived_truncated_60pct_bcts_4.laz", 358286, {"truncated", "time_order"}, ""},
    {"derived_truncated_midrecord_autzen_trim.las", 29351, {"truncated", "feet", "no_vertical"}, ""},
    {"derived_zero_bytes.laz", -1, {}, "is empty"},
    {"git_lfs_pointer_red-rocks.laz", -1, {}, "git-lfs pointer"},
    {"ign_Semis_2022_0906_6665_LA93_IGN69_nok.laz", -1, {}, "header has 0 bytes"},
    {"ign_crop_duplicate.laz", 849, {"no_vertical"}, ""},
    {"ign_donor_negative_gps_time.las", 1606, {"no_vertical", "negative_time", "repeated_returns", "return_zero"}, ""},
    {"ign_las_with_origin_dsmMarker.laz", 67826, {"no_vertical", "time_order"}, ""},
    {"ign_mnx_68_synthetic.laz", 1000, {"no_vertical", "no_good_time", "virtual_points", "no_source_id", "zero_angles", "return_zero"}, ""},
    {"ign_recipient_test.laz", 9580, {"no_vertical", "time_bit", "time_order", "whole_degrees"}, ""},
    {"ign_test_data_0436_6384_LA93_IGN69_single_point.laz", 1, {"crs_from_name", "time_bit", "whole_degrees"}, ""},
    {"ign_test_noepsg_043500_629205_IGN69.laz", 17845, {"header", "crs_missing", "time_bit", "repeated_returns", "unclassified"}, ""},
    {"ign_test_pdalfail_0643_6319_LA93_IGN69.laz", 89, {"header", "wkt_bit", "crs_from_name"}, ""},
    {"lasR_example.copc.laz", 30, {"no_vertical", "whole_degrees"}, ""},
    {"lasR_las14_pdrf6.laz", 135, {"header", "crs_missing", "time_order"}, ""},
    {"lasR_malformed_extrabytes.las", 10, {"header", "bounds", "crs_missing", "no_time", "no_source_id", "zero_angles"}, ""},
    {"lasR_nocrs.las", 30, {"crs_missing"}, ""},
    {"pdal_1.2-empty-geotiff-vlrs.las", 43, {"header", "crs_missing", "time_order", "no_source_id", "zero_angles", "unclassified"}, ""},
    {"pdal_1.2-with-color.copc.laz", 1065, {"mixed_units", "whole_degrees"}, ""},
    {"pdal_100-points.las", 100, {"crs_missing", "time_order"}, ""},
    {"pdal_bad-geotiff-keys.las", 10, {"returns_header", "no_vertical", "no_source_id", "zero_angles", "return_zero"}, ""},
    {"pdal_bad_vlr_count.las", 10, {"header", "no_vertical", "no_source_id", "zero_angles", "return_zero"}, ""},
    {"pdal_epsg_4326.las", 5380, {"returns_header", "degrees", "no_vertical", "no_time", "no_source_id", "zero_angles", "return_zero", "unclassified"}, ""},
    {"pdal_extrabytes.las", 1065, {"crs_missing", "time_order"}, ""},
    {"pdal_garbage_nVariableLength.las", 718, {"truncated", "header", "crs_missing", "no_time", "no_source_id", "zero_angles", "return_zero", "unclassified"}, ""},
    {"pdal_gps-time-nan.las", 1, {"crs_missing", "no_good_time", "bad_time", "return_zero"}, ""},
    {"pdal_hextest.las", 8, {"crs_missing", "no_time", "no_source_id", "zero_angles", "return_zero", "unclassified"}, ""},
    {"pdal_interesting.las", 1065, {"feet", "no_vertical", "time_order"}, ""},
    {"pdal_laszip-generated_with2bytespadding.laz", 1065, {"crs_missing", "time_order"}, ""},
    {"pdal_liblas-generated.laz", 1065, {"crs_missing", "time_order"}, ""},
    {"pdal_lots_of_vlr.las", 1, {"feet", "no_vertical"}, ""},
    {"pdal_no-points.las", 0, {"empty", "degrees", "no_vertical"}, ""},
    {"pdal_noise-dirty.las", 1065, {"crs_missing", "time_order"}, ""},
    {"pdal_permutations_1.0_0.las", 1, {"no_vertical", "no_time", "return_above_count"}, ""},
    {"pdal_permutations_1.0_1.las", 1, {"no_vertical", "time_not_adjusted", "return_above_count"}, ""},
    {"pdal_permutations_1.1_1.las", 1, {"no_vertical", "time_not_adjusted", "return_above_count"}, ""},
    {"pdal_permutations_1.2-no-points.las", 0, {"truncated", "empty", "crs_missing"}, ""},
    {"pdal_permutations_1.2_3.las", 1, {"no_vertical", "time_not_adjusted", "return_above_count"}, ""},
    {"pdal_prec3.las", 110, {"feet", "no_vertical"}, ""},
    {"pdal_simple-laszip-compressor-version-1.2r0.laz", 1065, {"crs_missing", "time_order"}, ""},
    {"pdal_simple.las", 1065, {"crs_missing", "time_order"}, ""},
    {"pdal_simple.laz", 1065, {"crs_missing", "time_order"}, ""},
    {"pdal_spurious.las", 1065, {"bounds", "degrees", "no_vertical", "time_order"}, ""},
    {"pdal_synthetic_test.las", 1, {"crs_missing", "no_good_time"}, ""},
    {"pdal_test1_4.las", 1000, {"feet", "no_vertical"}, ""},
    {"pdal_test_epsg_4326_axis.las", 10, {"degrees", "no_vertical", "no_source_id", "zero_angles", "return_zero"}, ""},
    {"pdal_wontcompress3.las", 1000, {"no_vertical", "time_order"}, ""},
};
// clang-format on

class OddFile : public testing::TestWithParam<Odd> {};

TEST_P(OddFile, GivesWhatItCanOrSaysWhyNot) {
  const Odd& odd = GetParam();
  const std::filesystem::path folder = std::filesystem::path(CORNICE_TEST_DATA) / "robustness";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no folder of odd files at " << folder;
  ASSERT_TRUE(std::filesystem::exists(folder / odd.file));
  if (odd.points < 0) {
    try {
      examine(folder / odd.file);
      ADD_FAILURE() << "was examined";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(odd.file));
      EXPECT_THAT(error.what(), testing::HasSubstr(odd.error));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
    }
    return;
  }
  const FileFacts file = examine(folder / odd.file);
  EXPECT_EQ(std::get<PointFacts>(file.facts).readable, static_cast<std::uint64_t>(odd.points));
  std::vector<std::string> ids;
  for (const Defect& defect : file.defects) {
    ids.push_back(defect.id);
    EXPECT_THAT(defect.text, testing::Not(testing::HasSubstr("\n")));
  }
  EXPECT_EQ(ids, odd.defects);
}

INSTANTIATE_TEST_SUITE_P(Info, OddFile, testing::ValuesIn(kOdd), [](const auto& instance) {
  std::string name = instance.param.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
});

TEST(OddFiles, AreAllInTheTable) {
  const std::filesystem::path folder = std::filesystem::path(CORNICE_TEST_DATA) / "robustness";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no folder of odd files at " << folder;
  std::vector<std::string> present, known;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    present.push_back(entry.path().filename().string());
  }
  for (const Odd& odd : kOdd) known.push_back(odd.file);
  EXPECT_THAT(known, testing::UnorderedElementsAreArray(present));
}

}  // namespace
}  // namespace cornice::info
