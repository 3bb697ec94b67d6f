// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/class_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"

namespace cornice::normals {
namespace {

const std::filesystem::path kConfig = std::filesystem::path(CORNICE_SOURCE_DIR) / "config";

struct Sample {
  float height;
  std::uint8_t code;
  std::uint8_t flags = 0;
};

PointCloud cloud(const std::vector<Sample>& samples) {
  PointCloud points;
  points.origin = {2600000, 1200000, 1000};
  for (const Sample& s : samples) {
    points.positions.push_back({0, 0, s.height - 1000.0f});
    points.classification.push_back(s.code);
    points.flags.push_back(s.flags);
  }
  return points;
}

std::string problem_of(const std::string& yaml) {
  const cornice::test::TemporaryFolder folder;
  cornice::test::write_text(folder / "c.yaml", yaml);
  try {
    read_class_rules(folder / "c.yaml");
  } catch (const InputError& error) {
    return error.problem();
  }
  return "";
}

TEST(ClassFilter, TakesEveryClassOfLidarHdAbove2200MetresWhereRockIsNotClassed) {
  FilterCounts counts;
  const auto keep = points_to_keep(
      cloud({{2000, 2}, {2000, 4}, {2000, 1}, {2200, 1}, {2201, 1}, {2201, 4}, {3000, 9}}),
      built_in_rules("lidarhd"), counts);
  EXPECT_EQ(keep, (std::vector<std::uint8_t>{1, 0, 0, 0, 1, 1, 1}));
  EXPECT_EQ(counts.kept, 4u);
  EXPECT_EQ(counts.other_class, 3u);
}

TEST(ClassFilter, DropsNoiseVirtualAndWithheldPointsAtAnyHeightAndSaysHowMany) {
  FilterCounts counts;
  const auto keep = points_to_keep(cloud({{3000, 7},
                                          {3000, 65},
                                          {3000, 66},
                                          {3000, 2, kSynthetic},
                                          {3000, 2, kWithheld},
                                          {3000, 2, kOverlap}}),
                                   built_in_rules("lidarhd"), counts);
  EXPECT_EQ(keep, (std::vector<std::uint8_t>{0, 0, 0, 0, 0, 1}));
  EXPECT_EQ(counts.noise, 2u);
  EXPECT_EQ(counts.synthetic, 2u);
  EXPECT_EQ(counts.withheld, 1u);
  EXPECT_EQ(counts.dropped_by_class[65], 1u);
  EXPECT_EQ(counts.kept_by_class[2], 1u);
}

TEST(ClassFilter, KeepsOnlyTheClassesGiven) {
  FilterCounts counts;
  const auto keep = points_to_keep(cloud({{10, 2}, {10, 3}, {10, 7}, {10, 18}}),
                                   rules_for_classes({3, 7}), counts);
  EXPECT_EQ(keep, (std::vector<std::uint8_t>{0, 1, 1, 0}));
}

TEST(ClassFilter, GoesByTheFileName) {
  EXPECT_EQ(rules_for_file("a/swisssurface3d_2019_2746-1234_2056_5728.las.zip"), "swisssurface3d");
  EXPECT_EQ(rules_for_file("LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.copc.laz"), "lidarhd");
  EXPECT_EQ(rules_for_file("cloud.las"), "any");
}

TEST(ClassFilter, HasTheSameRulesBuiltInAsInTheConfigurations) {
  EXPECT_EQ(read_class_rules(kConfig / "swisssurface3d.yaml"), built_in_rules("swisssurface3d"));
  EXPECT_EQ(read_class_rules(kConfig / "lidarhd.yaml"), built_in_rules("lidarhd"));
}

TEST(ClassFilter, RefusesAnUnknownProduct) {
  EXPECT_THROW(built_in_rules("nonsense"), UsageError);
  for (const std::string& name : rule_names()) EXPECT_NO_THROW(built_in_rules(name));
}

TEST(ClassFilter, SaysWhatIsWrongWithAConfiguration) {
  using testing::HasSubstr;
  EXPECT_THAT(problem_of("poisson: {}"), HasSubstr("no section \"normals\""));
  EXPECT_THAT(problem_of("normals: {classes: [{keep: [2]}], nosie: [7]}"), HasSubstr("\"nosie\""));
  EXPECT_THAT(problem_of("normals: {classes: [{keep: [2, 256]}]}"), HasSubstr("0 to 255"));
  EXPECT_THAT(problem_of("normals: {classes: [{keep: [two]}]}"), HasSubstr("0 to 255"));
  EXPECT_THAT(problem_of("normals: {classes: []}"), HasSubstr("list of bands"));
  EXPECT_THAT(problem_of("normals: {classes: [{keep: [2]}, {keep: [3], up-to-m: 5}]}"),
              HasSubstr("rising"));
  EXPECT_THAT(problem_of("normals: {classes: [{keep: [2], up-to-m: high}]}"), HasSubstr("metres"));
  EXPECT_THAT(problem_of("normals: [["), HasSubstr("YAML"));
  EXPECT_THROW(read_class_rules("/nowhere.yaml"), InputError);
}

}  // namespace
}  // namespace cornice::normals
