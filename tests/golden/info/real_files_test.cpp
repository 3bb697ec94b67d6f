// SPDX-License-Identifier: GPL-3.0-or-later
// Real files against facts measured by other means (the index that lies beside them).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "stages/info/examine.h"
#include "stages/info/show.h"

namespace cornice::info {
namespace {

struct Range {
  double low, high;
};
/// Of formats without a time.
constexpr Range kNoTime{1, -1};

/// Facts as the index has them: bounds to 0.1, times and angles to 1.
struct Known {
  const char* file;
  std::uint64_t points;
  int version_minor;
  int point_format;
  std::array<double, 4> bounds;  // min x, max x, min y, max y
  Range time_s;                  // of all finite times, zero included
  Range angle_deg;
  std::uint64_t distinct_angles;
  std::size_t point_source_ids;
  int horizontal_epsg;  // 0: none in file and name, or one without a code
  int vertical_epsg;
};

// clang-format off
constexpr Known kKnown[] = {
    {"bcts_ca/bcts_1.laz", 531662, 2, 1, {885022.4, 885210.2, 629157.2, 629400.0}, {347063, 347872}, {-15, 15}, 26, 3, 3005, 5713},
    {"bcts_ca/bcts_2.laz", 823945, 2, 1, {885024.1, 885217.1, 629400.0, 629700.0}, {347068, 347878}, {-15, 15}, 27, 3, 3005, 5713},
    {"bcts_ca/bcts_3.laz", 887254, 2, 1, {885026.3, 885224.0, 629700.0, 630000.0}, {347075, 347883}, {-15, 15}, 31, 3, 3005, 5713},
    {"bcts_ca/bcts_4.laz", 591489, 2, 1, {885028.4, 885228.9, 630000.0, 630219.5}, {347080, 347887}, {-15, 15}, 31, 3, 3005, 5713},
    {"ign_adjacent_1km/test_semis_2023_0299_6802_LA93_IGN69.laz", 278810, 4, 6, {299000.0, 300000.0, 6801000.0, 6802000.0}, {0, 396952603}, {-20, 20}, 3458, 5, 2154, 5720},
    {"ign_adjacent_1km/test_semis_2023_0300_6802_LA93_IGN69.laz", 240482, 4, 6, {300000.0, 301000.0, 6801000.0, 6802000.0}, {396950273, 396952613}, {-20, 20}, 3458, 4, 2154, 5720},
    {"ign_adjacent_50x100/792000_6272000-50mx100m-left.laz", 14938, 4, 6, {792000.0, 792050.0, 6271171.7, 6271271.7}, {305467631, 305467648}, {11, 13}, 3, 1, 2154, 0},
    {"ign_adjacent_50x100/792000_6272000-50mx100m-right.laz", 12879, 4, 6, {792050.0, 792100.0, 6271171.7, 6271271.7}, {305467631, 305467648}, {10, 11}, 2, 1, 2154, 0},
    {"ign_lidarforfuel/1_42.laz", 419079, 4, 6, {817572.3, 817672.3, 6460767.7, 6460867.7}, {338993841, 339489594}, {-9, -5}, 44, 2, 2154, 0},
    {"ign_lidarforfuel/2_42.laz", 315658, 4, 6, {815259.6, 815359.6, 6461919.3, 6462019.3}, {339488429, 339488431}, {0, 5}, 47, 1, 2154, 0},
    {"ign_lidarforfuel/2_bas_lig.laz", 247194, 4, 6, {368478.1, 368578.1, 6807406.8, 6807506.8}, {390477387, 390477393}, {5, 9}, 42, 2, 2154, 0},
    {"ign_lidarforfuel/M30_FontBlanche.laz", 149764, 4, 6, {917631.2, 917696.6, 6241561.7, 6241626.9}, {308733496, 308733513}, {-3, 0}, 4, 1, 2154, 0},
    {"ign_mnx/bat.laz", 137379, 4, 6, {931118.6, 931175.8, 6449651.3, 6449693.8}, {312886441, 314944216}, {-28, 29}, 20, 9, 2154, 0},
    {"ign_mnx/corse.laz", 30392, 4, 8, {1216477.0, 1216525.0, 6051706.0, 6051746.0}, {305355957, 309154326}, {-28, 13}, 7, 2, 2154, 0},
    {"ign_mnx/pont.laz", 249582, 4, 6, {726831.0, 726910.2, 6764269.1, 6764387.2}, {0, 364647924}, {0, 22}, 1389, 3, 2154, 0},
    {"ign_other/870000_6618000.subset.50mx100m.las", 70840, 4, 8, {870200.0, 870300.0, 6617083.3, 6617145.2}, {297417272, 297417286}, {0, 4}, 5, 1, 0, 0},
    {"ign_other/Semis_2022_0906_6665_LA93_IGN69_ok.laz", 64572, 4, 7, {906000.0, 907000.0, 6664000.0, 6665000.0}, {342978726, 343026130}, {-11, 34}, 467, 2, 2154, 5720},
    {"ign_other/St_Barth_RGAF09_UTM20N_IGN_1988_SB_subset_100m.laz", 249120, 2, 1, {515000.0, 515100.0, 1981000.0, 1981100.0}, {237057268, 237058539}, {-20, 20}, 22, 4, 0, 0},
    {"ign_other/las_with_several_extra_byte_bloc.laz", 697721, 4, 8, {484649.4, 485000.0, 6632629.7, 6633000.0}, {390583952, 390583958}, {-19, -7}, 938, 1, 2154, 0},
    {"ign_other/sample_lareunion_epsg2975.laz", 59712, 4, 8, {377000.0, 377050.0, 7655950.0, 7656000.0}, {375760951, 375761439}, {8, 16}, 37, 2, 2975, 0},
    {"ign_other/test_semis_2021_0382_6565_LA93_IGN69.laz", 256289, 4, 6, {382022.2, 383000.0, 6564000.0, 6565000.0}, {314521663, 314523875}, {-7, 20}, 28, 2, 2154, 5720},
    {"ign_other/test_semis_2021_0382_6565_LA93_IGN69_cropped.laz", 218731, 4, 7, {382250.0, 383000.0, 6564000.0, 6565000.0}, {314521663, 314523874}, {-2, 20}, 23, 2, 2154, 5720},
    {"ign_other/test_semis_2023_0292_6833_LA93_IGN69.laz", 289055, 4, 6, {292000.0, 293000.0, 6832000.0, 6833000.0}, {0, 384934102}, {-20, 20}, 3382, 5, 2154, 5720},
    {"ign_tiles_50m/test_data_77050_627755_LA93_IGN69.copc.laz", 21172, 4, 6, {770500.0, 770550.0, 6277500.0, 6277550.0}, {306234562, 306235309}, {-29, -7}, 6, 2, 2154, 5720},
    {"ign_tiles_50m/test_data_77050_627755_LA93_IGN69.laz", 73355, 4, 8, {770500.0, 770541.7, 6277500.0, 6277550.0}, {306234562, 306235309}, {-29, -7}, 6, 2, 2154, 5720},
    {"ign_tiles_50m/test_data_77050_627760_LA93_IGN69.laz", 56035, 4, 8, {770500.0, 770550.0, 6277550.0, 6277600.0}, {306234562, 306235309}, {-29, -5}, 4, 2, 2154, 5720},
    {"ign_tiles_50m/test_data_77055_627755_LA93_IGN69.laz", 72770, 4, 8, {770550.0, 770600.0, 6277500.0, 6277550.0}, {306234563, 306235309}, {-29, -7}, 6, 2, 2154, 5720},
    {"ign_tiles_50m/test_data_77055_627760_LA93_IGN69.laz", 60653, 4, 8, {770550.0, 770600.0, 6277550.0, 6277600.0}, {306234563, 306235309}, {-29, -5}, 4, 2, 2154, 5720},
    {"ign_tiles_50m/test_data_77060_627755_LA93_IGN69.laz", 83518, 4, 8, {770600.0, 770650.0, 6277500.0, 6277550.0}, {306234563, 306235308}, {-29, -7}, 6, 2, 2154, 5720},
    {"ign_tiles_50m/test_data_77060_627760_LA93_IGN69.laz", 59606, 4, 8, {770600.0, 770650.0, 6277550.0, 6277600.0}, {306234563, 306235308}, {-29, -5}, 4, 2, 2154, 5720},
    {"isprs_no_gps/CSite1_red1-utm.laz", 522674, 2, 0, {512049.5, 513150.2, 5403059.3, 5404100.0}, kNoTime, {0, 0}, 1, 1, 32632, 0},
    {"isprs_no_gps/CSite2_orig-utm.laz", 486800, 2, 0, {513449.7, 513870.3, 5402649.9, 5403282.9}, kNoTime, {0, 0}, 1, 1, 32632, 0},
    {"isprs_no_gps/FSite5_orig-utm.laz", 628320, 2, 0, {493650.0, 495250.6, 5419770.0, 5421031.4}, kNoTime, {0, 0}, 1, 1, 32632, 0},
    {"isprs_no_gps/FSite6_orig-utm.laz", 550256, 2, 0, {496329.3, 497950.0, 5420746.4, 5421816.8}, kNoTime, {0, 0}, 1, 1, 32632, 0},
    {"misc_als/las_chablais3.laz", 92097, 2, 1, {974326.0, 974408.0, 6581619.0, 6581702.0}, {29216, 52961}, {0, 0}, 1, 5, 2154, 0},
    {"misc_als/lidR_Megaplot_full.laz", 805322, 2, 1, {684745.6, 685534.5, 5017747.0, 5018203.0}, {482919, 484386}, {-15, 16}, 30, 1, 0, 0},
    {"misc_als/lidR_MixedConifer_full.laz", 47602, 2, 1, {481253.3, 481354.9, 3812921.1, 3813020.6}, {149928, 152208}, {-10, 19}, 25, 1, 0, 0},
    {"misc_als/lidR_Topography.laz", 73403, 2, 1, {273357.1, 273642.9, 5274357.1, 5274642.8}, {220367381, 220367385}, {-6, 1}, 8, 1, 2949, 0},
    {"misc_als/lidR_Topography_2011_200m.laz", 74580, 0, 0, {332600.0, 332800.0, 5238500.0, 5238700.0}, kNoTime, {0, 0}, 1, 1, 0, 0},
    {"misc_als/lidR_Topography_haliburton_98m_relief.laz", 133764, 2, 1, {684715.6, 685296.5, 5017848.3, 5018303.2}, {0, 0}, {0, 0}, 1, 136, 0, 0},
    {"misc_als/pdal_4_6_crop.las", 23875, 2, 3, {1639600.0, 1639800.0, 1454500.0, 1454700.0}, {81616202, 81616203}, {14, 17}, 4, 1, 2903, 6360},
    {"misc_als/pdal_autzen_trim.las", 110000, 2, 3, {636001.8, 637179.2, 848935.2, 849497.9}, {245379, 245386}, {-18, -1}, 18, 1, 2994, 0},
    {"misc_als/pdal_autzen_trim_7.las", 110000, 4, 7, {636001.8, 637179.2, 848935.2, 849497.9}, {245379, 245386}, {-18, -1}, 18, 1, 0, 0},
    {"misc_als/pdal_hexbin-crop_afghanistan.las", 38367, 2, 1, {393775.8, 394069.2, 3689071.9, 3689273.1}, {0, 0}, {0, 0}, 1, 1, 32642, 0},
    {"misc_als/pdal_lone-star.copc.laz", 518862, 4, 6, {515368.6, 515401.0, 4918340.4, 4918381.1}, {0, 0}, {0, 0}, 1, 1, 0, 0},
    {"misc_als/pdal_mvk-thin.las", 6280, 2, 1, {2045001.8, 2049993.9, 1267501.2, 1272499.8}, {338834, 340756}, {-30, 27}, 58, 3, 2255, 6360},
    {"misc_als/pdal_sample_c.las", 14408, 2, 3, {674521.9, 674605.3, 1206740.1, 1206815.0}, {159214262, 159214549}, {-39, 59}, 29, 4, 0, 0},
    {"misc_als/pdal_warsaw_small.las", 3000, 2, 3, {639913.3, 639946.8, 485143.1, 485175.9}, {206860645, 206946276}, {-10, 9}, 4, 2, 0, 0},
    {"misc_als/silvimetric_autzen_test.copc.laz", 61201, 4, 7, {635579.2, 639003.7, 848887.5, 853534.4}, {245370, 249784}, {-21, 19}, 41, 9, 2992, 6360},
};
// clang-format on

class RealFile : public testing::TestWithParam<Known> {};

TEST_P(RealFile, IsWhatTheIndexSays) {
  const Known& known = GetParam();
  const std::filesystem::path folder = CORNICE_TEST_DATA;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no folder of real files at " << folder;
  const std::filesystem::path path = folder / known.file;
  ASSERT_TRUE(std::filesystem::exists(path)) << path;
  const FileFacts file = examine(path);
  const auto& facts = std::get<PointFacts>(file.facts);
  EXPECT_EQ(facts.readable, known.points);
  EXPECT_EQ(facts.header.point_count, known.points);
  EXPECT_EQ(facts.problem, "");
  EXPECT_EQ(facts.header.version_minor, known.version_minor);
  EXPECT_EQ(facts.header.point_format, known.point_format);
  EXPECT_NEAR(facts.bounds.min.x, known.bounds[0], 0.0501);
  EXPECT_NEAR(facts.bounds.max.x, known.bounds[1], 0.0501);
  EXPECT_NEAR(facts.bounds.min.y, known.bounds[2], 0.0501);
  EXPECT_NEAR(facts.bounds.max.y, known.bounds[3], 0.0501);
  EXPECT_TRUE(facts.bounds_agree);
  EXPECT_EQ(facts.time.has_field, known.time_s.low <= known.time_s.high);
  if (facts.time.has_field) {
    EXPECT_NEAR(facts.time.min_s.value(), known.time_s.low, 0.501);
    EXPECT_NEAR(facts.time.max_s.value(), known.time_s.high, 0.501);
  }
  EXPECT_NEAR(facts.angle.min_deg.value(), known.angle_deg.low, 0.501);
  EXPECT_NEAR(facts.angle.max_deg.value(), known.angle_deg.high, 0.501);
  EXPECT_EQ(facts.angle.distinct, known.distinct_angles);
  std::set<int> ids;
  std::uint64_t in_lines = 0;
  for (const LineFacts& line : facts.lines) {
    ids.insert(line.point_source_id);
    in_lines += line.points;
  }
  EXPECT_EQ(ids.size(), known.point_source_ids);
  EXPECT_EQ(in_lines, known.points);
  EXPECT_EQ(facts.header.crs.horizontal_epsg, known.horizontal_epsg);
  EXPECT_EQ(facts.header.crs.vertical_epsg, known.vertical_epsg);
  EXPECT_FALSE(screen_text(file).empty());
}

INSTANTIATE_TEST_SUITE_P(Info, RealFile, testing::ValuesIn(kKnown), [](const auto& instance) {
  std::string name = instance.param.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
});

PointFacts facts_of(const char* file) {
  return std::get<PointFacts>(examine(std::filesystem::path(CORNICE_TEST_DATA) / file).facts);
}

TEST(RealFiles, TellWhatTheirKindIsKnownFor) {
  if (!std::filesystem::exists(CORNICE_TEST_DATA)) GTEST_SKIP() << "no folder of real files";
  const PointFacts bridge = facts_of("ign_mnx/pont.laz");
  EXPECT_EQ(bridge.virtual_without_time, 24006u);
  EXPECT_EQ(bridge.classes[66], 24006u);
  const PointFacts cliff = facts_of("ign_mnx/corse.laz");
  EXPECT_TRUE(cliff.angle.whole_degrees);
  EXPECT_EQ(cliff.time.kind, TimeKind::kAdjustedStandard);
  EXPECT_EQ(cliff.time.header_type, GpsTimeType::kWeekSeconds);
  ASSERT_EQ(cliff.lines.size(), 2u);
  for (const LineFacts& line : cliff.lines) EXPECT_EQ(line.passes, 2u);
  const PointFacts mixed = facts_of("misc_als/lidR_MixedConifer_full.laz");
  ASSERT_EQ(mixed.lines.size(), 1u);
  EXPECT_GE(mixed.lines[0].passes, 3u);
  const PointFacts feet = facts_of("misc_als/pdal_4_6_crop.las");
  EXPECT_NEAR(feet.header.crs.metres_per_unit, 1200.0 / 3937.0, 1e-9);
  EXPECT_NEAR(*feet.density_per_m2, 6.43, 0.5);
  EXPECT_NEAR(*facts_of("bcts_ca/bcts_1.laz").density_per_m2, 11.66, 0.5);
}

}  // namespace
}  // namespace cornice::info
