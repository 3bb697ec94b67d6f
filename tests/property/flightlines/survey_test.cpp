// SPDX-License-Identifier: GPL-3.0-or-later
// Whatever goes wrong in the fields of a simulated survey: every pass is one line, and its path,
// sign and azimuth are right.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "bench/flightlines/survey_score.h"

namespace cornice::bench {
namespace {

namespace sim = cornice::simulate;

struct Case {
  const char* name;
  std::vector<std::string> defects;
  sim::ScannerPattern pattern = sim::ScannerPattern::kPolygon;
  int channels = 1;
  sim::ChannelTag tag = sim::ChannelTag::kPointSourceId;
  double most_rms_m = 1.0;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

sim::SurveyOptions survey_of(const Case& c) {
  sim::SurveyOptions options;
  options.scene_file = std::filesystem::path(CORNICE_SOURCE_DIR) / "samples/scenes/valley.yaml";
  options.product = sim::SurveyProduct::kLidarHd;
  options.tiles = "2x1";
  options.tile_m = 200.0;
  options.density = 0.6;
  options.scanner.pattern = c.pattern;
  options.scanner.channels = c.channels;
  options.channel_tag = c.tag;
  options.defects = c.defects;
  return options;
}

/// One scene for all cases: it is the same for all, and building it takes longer than the rest.
const sim::Scene& the_scene() {
  static const std::unique_ptr<sim::Scene> scene = build_scene(survey_of({"", {}}), 2);
  return *scene;
}

class SpoiledSurvey : public testing::TestWithParam<Case> {};

TEST_P(SpoiledSurvey, GivesEveryPassAsOneLineWithItsPath) {
  const FlownSurvey flown = fly_in_memory(survey_of(GetParam()), the_scene(), 2);
  double seconds = 0.0;
  const auto found = find_lines(flown.tiles, 2, seconds);
  const Score score = score_lines(flown, found);
  EXPECT_GE(score.lines, 2);
  EXPECT_EQ(score.split_errors, 0);
  EXPECT_EQ(score.without_path, 0);
  EXPECT_EQ(score.sign_errors, 0);
  EXPECT_LT(score.azimuth_error_deg, 0.1);
  EXPECT_LT(score.rms_m(), GetParam().most_rms_m);
}

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Defects, SpoiledSurvey,
    testing::Values(Case{"None", {}}, Case{"ZeroedIds", {"zeroed-source-ids"}},
                    Case{"ReusedIds", {"reused-source-ids"}}, Case{"TwoSurveys", {"two-surveys"}},
                    Case{"WeekRollover", {"week-rollover"}}, Case{"Unordered", {"unordered"}},
                    Case{"ReversedAngle", {"reversed-angle"}},
                    Case{"ReversedAngleOfEveryOtherLine", {"reversed-angle-alternate"}},
                    Case{"WholeDegrees",
                         {"whole-degrees"},
                         sim::ScannerPattern::kOscillating,
                         1,
                         sim::ChannelTag::kPointSourceId,
                         5.0},
                    Case{"VirtualPoints", {"virtual-points"}},
                    Case{"Dirty",
                         {"zero-times", "duplicate-points", "return-numbers", "absurd-angles",
                          "outliers"}},
                    Case{"PalmerZeroedIds", {"zeroed-source-ids"}, sim::ScannerPattern::kPalmer},
                    Case{"TwoChannelsById", {}, sim::ScannerPattern::kPolygon, 2},
                    Case{"TwoChannelsByField",
                         {},
                         sim::ScannerPattern::kPolygon,
                         2,
                         sim::ChannelTag::kScannerChannel},
                    Case{"TwoChannelsByUserDataAndZeroedIds",
                         {"zeroed-source-ids"},
                         sim::ScannerPattern::kPolygon,
                         2,
                         sim::ChannelTag::kUserData}),
    name_of);

}  // namespace
}  // namespace cornice::bench
