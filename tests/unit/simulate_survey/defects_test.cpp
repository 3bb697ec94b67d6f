// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/defects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/points/point_cloud.h"
#include "stages/simulate/trajectory.h"

namespace cornice::simulate {
namespace {

constexpr std::uint64_t kSeed = 5;

DefectOptions swiss(const std::vector<std::string>& entries) {
  return parse_defects(SurveyProduct::kSwissSurface3d, entries);
}

std::vector<SurveyPoint> pulse(int returns) {
  std::vector<SurveyPoint> points(static_cast<std::size_t>(returns));
  for (int i = 0; i < returns; ++i) {
    SurveyPoint& point = points[static_cast<std::size_t>(i)];
    point.gps_time_s = 3e8;
    point.scan_angle_deg = 12.345f;
    point.return_number = static_cast<std::uint8_t>(i + 1);
    point.return_count = static_cast<std::uint8_t>(returns);
    point.classification = kClassGround;
    point.normal = {1.0f, 0.0f, 0.0f};
    point.point_source_id = 17;
  }
  return points;
}

Trajectory flown(double survey_break_s = 0.0) {
  FlightOptions flight;
  flight.start_time_s = 3e8;
  flight.survey_break_s = survey_break_s;
  return Trajectory::plan(flight, {}, {0.0, 0.0, 2000.0, 2000.0}, {500.0, 500.0, 500.0}, 1);
}

TEST(Defects, EveryNameIsTakenAndRecordedAndNothingElseIs) {
  for (const DefectName& defect : defect_names()) {
    const std::vector<std::string> names = applied(swiss({defect.name}));
    ASSERT_EQ(names.size(), 1u) << defect.name;
    EXPECT_EQ(names[0].substr(0, names[0].find('=')), defect.name);
    EXPECT_NE(std::string(defect.help), "");
    if (defect.default_value == 0.0) {
      EXPECT_THROW(swiss({std::string(defect.name) + "=1"}), UsageError) << defect.name;
    } else {
      EXPECT_EQ(applied(swiss({std::string(defect.name) + "=0.25"}))[0],
                std::string(defect.name) + "=0.25");
      EXPECT_THROW(swiss({std::string(defect.name) + "=-1"}), UsageError);
      EXPECT_THROW(swiss({std::string(defect.name) + "=nan"}), UsageError);
      EXPECT_THROW(swiss({std::string(defect.name) + "=0.1x"}), UsageError);
    }
  }
  EXPECT_TRUE(applied(swiss({})).empty());
  EXPECT_THROW(swiss({"outliers=2"}), UsageError);
}

TEST(Defects, AnUnknownNameIsRefusedWithTheKnownOnes) {
  try {
    swiss({"reversed"});
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("reversed-angle-alternate"), std::string::npos);
  }
}

TEST(Defects, LidarHdHasVirtualPointsOnWaterUnlessNoneIsAskedFor) {
  EXPECT_TRUE(parse_defects(SurveyProduct::kLidarHd, {}).virtual_on_water);
  EXPECT_FALSE(parse_defects(SurveyProduct::kLidarHd, {"none"}).virtual_on_water);
  EXPECT_FALSE(swiss({}).virtual_on_water);
}

TEST(Defects, DefectsCompose) {
  const DefectOptions defects = swiss({"reversed-angle", "outliers=0.1", "lost-time-bit"});
  EXPECT_EQ(defects.angle_sign, AngleSign::kReversed);
  EXPECT_EQ(defects.outliers, 0.1);
  EXPECT_TRUE(defects.lost_time_bit);
  EXPECT_EQ(applied(defects).size(), 3u);
}

TEST(Defects, WithoutDefectsAPulseStaysAsItIs) {
  std::vector<SurveyPoint> points = pulse(3);
  apply_defects({}, kSeed, 1, 0, points);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[2].return_number, 3);
  EXPECT_EQ(points[2].scan_angle_deg, 12.345f);
  EXPECT_EQ(points[2].gps_time_s, 3e8);
}

TEST(Defects, WholeDegreesAreRounded) {
  std::vector<SurveyPoint> points = pulse(1);
  apply_defects(swiss({"whole-degrees"}), kSeed, 1, 0, points);
  EXPECT_EQ(points[0].scan_angle_deg, 12.0f);
}

TEST(Defects, ReturnNumbersRepeatOrStartAtTwo) {
  const DefectOptions defects = swiss({"return-numbers=1"});
  int repeated = 0, shifted = 0;
  for (std::uint64_t key = 0; key < 200; ++key) {
    std::vector<SurveyPoint> points = pulse(3);
    apply_defects(defects, kSeed, key, 0, points);
    if (points[0].return_number == 2 && points[2].return_number == 4) ++shifted;
    if (points[0].return_number == 1 && points[2].return_number == 1) ++repeated;
    EXPECT_EQ(points[0].return_count, 3);
  }
  EXPECT_EQ(repeated + shifted, 200);
  EXPECT_GT(repeated, 50);
  EXPECT_GT(shifted, 50);
}

TEST(Defects, DuplicatesAreWholeCopiesBehindTheirPulse) {
  std::vector<SurveyPoint> points = pulse(2);
  apply_defects(swiss({"duplicate-points=1"}), kSeed, 1, 0, points);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_EQ(points[2].return_number, 1);
  EXPECT_EQ(points[3].return_number, 2);
}

TEST(Defects, OnlyThePointsOfThePulseAreTouched) {
  std::vector<SurveyPoint> points = pulse(2);
  const std::vector<SurveyPoint> second = pulse(1);
  points.insert(points.end(), second.begin(), second.end());
  apply_defects(swiss({"zero-times=1"}), kSeed, 1, 2, points);
  EXPECT_EQ(points[0].gps_time_s, 3e8);
  EXPECT_EQ(points[1].gps_time_s, 3e8);
  EXPECT_EQ(points[2].gps_time_s, 0.0);
}

TEST(Defects, AbsurdAnglesComeWithWithheldOrSynthetic) {
  std::set<int> flags;
  for (std::uint64_t key = 0; key < 100; ++key) {
    std::vector<SurveyPoint> points = pulse(1);
    apply_defects(swiss({"absurd-angles=1"}), kSeed, key, 0, points);
    EXPECT_GE(std::abs(points[0].scan_angle_deg), 75.0f);
    EXPECT_LE(std::abs(points[0].scan_angle_deg), 90.0f);
    flags.insert(points[0].flags);
  }
  EXPECT_EQ(flags, (std::set<int>{kWithheld, kSynthetic}));
}

TEST(Defects, OnlySteepGroundIsMisclassified) {
  const DefectOptions defects = swiss({"misclassified=1"});
  for (std::uint64_t key = 0; key < 50; ++key) {
    std::vector<SurveyPoint> points = pulse(1);
    apply_defects(defects, kSeed, key, 0, points);
    EXPECT_NE(points[0].classification, kClassGround);
    points = pulse(1);
    points[0].normal = {0.0f, 0.0f, 1.0f};
    apply_defects(defects, kSeed, key, 0, points);
    EXPECT_EQ(points[0].classification, kClassGround);
  }
}

TEST(Defects, RatesAreKept) {
  int zero = 0;
  for (std::uint64_t key = 0; key < 20000; ++key) {
    std::vector<SurveyPoint> points = pulse(1);
    apply_defects(swiss({"zero-times=0.05"}), kSeed, key, 0, points);
    zero += points[0].gps_time_s == 0.0 ? 1 : 0;
  }
  EXPECT_NEAR(zero, 1000, 120);
}

TEST(Defects, OutliersLieFiveToTwoHundredMetresAwayOnBothSides) {
  const DefectOptions defects = swiss({"outliers=0.5"});
  int high = 0, low = 0;
  for (std::uint64_t key = 0; key < 2000; ++key) {
    const double shift = outlier_shift_m(defects, kSeed, key, 0);
    if (shift == 0.0) continue;
    EXPECT_GE(std::abs(shift), 5.0);
    EXPECT_LE(std::abs(shift), 200.0);
    (shift < 0.0 ? high : low) += 1;
  }
  EXPECT_NEAR(high, 500, 80);
  EXPECT_NEAR(low, 500, 80);
  EXPECT_EQ(outlier_shift_m({}, kSeed, 1, 0), 0.0);
}

TEST(Lines, EveryPassHasItsOwnIdUnlessADefectSaysOtherwise) {
  const Trajectory trajectory = flown();
  const std::size_t passes = trajectory.passes().size();
  ASSERT_GE(passes, 4u);
  const auto ids = [&](const DefectOptions& defects) {
    std::multiset<int> result;
    for (const SurveyLine& line :
         survey_lines(trajectory, 1, ChannelTag::kPointSourceId, defects, kSeed))
      result.insert(line.point_source_id);
    return result;
  };
  const std::multiset<int> clean = ids({});
  EXPECT_EQ(std::set<int>(clean.begin(), clean.end()).size(), passes);
  EXPECT_EQ(ids(swiss({"zeroed-source-ids"})).count(0), passes);
  const std::multiset<int> reused = ids(swiss({"reused-source-ids"}));
  EXPECT_EQ(std::set<int>(reused.begin(), reused.end()).size(), (passes + 1) / 2);
}

TEST(Lines, TheSecondSurveyUsesTheSameIdsAgain) {
  const Trajectory trajectory = flown(kSurveyBreakS);
  const auto lines =
      survey_lines(trajectory, 1, ChannelTag::kPointSourceId, swiss({"two-surveys"}), kSeed);
  std::set<int> first, second;
  for (const SurveyLine& line : lines)
    (trajectory.passes()[static_cast<std::size_t>(line.pass)].survey == 0 ? first : second)
        .insert(line.point_source_id);
  EXPECT_FALSE(second.empty());
  EXPECT_TRUE(std::includes(first.begin(), first.end(), second.begin(), second.end()));
}

TEST(Lines, ChannelsAreToldApartByTheFieldAskedFor) {
  const Trajectory trajectory = flown();
  const auto pair = [&](ChannelTag tag) {
    const auto lines = survey_lines(trajectory, 2, tag, {}, kSeed);
    return std::pair{lines[0], lines[1]};
  };
  const auto [a, b] = pair(ChannelTag::kPointSourceId);
  EXPECT_EQ(a.pass, b.pass);
  EXPECT_EQ(b.point_source_id, a.point_source_id + 1000);
  EXPECT_EQ(b.recorded_channel, 0);
  const auto [c, d] = pair(ChannelTag::kScannerChannel);
  EXPECT_EQ(c.point_source_id, d.point_source_id);
  EXPECT_EQ(c.recorded_channel, 0);
  EXPECT_EQ(d.recorded_channel, 1);
  const auto [e, f] = pair(ChannelTag::kUserData);
  EXPECT_EQ(e.point_source_id, f.point_source_id);
  EXPECT_EQ(e.user_data, 6);
  EXPECT_EQ(f.user_data, 7);
}

TEST(Lines, SignsAndOffsetsFollowTheDefects) {
  const Trajectory trajectory = flown();
  const auto lines = [&](const std::vector<std::string>& names) {
    return survey_lines(trajectory, 1, ChannelTag::kPointSourceId, swiss(names), kSeed);
  };
  for (const SurveyLine& line : lines({})) {
    EXPECT_EQ(line.angle_sign, 1);
    EXPECT_EQ(norm(line.offset), 0.0);
  }
  for (const SurveyLine& line : lines({"reversed-angle"})) EXPECT_EQ(line.angle_sign, -1);
  for (const SurveyLine& line : lines({"reversed-angle-alternate"}))
    EXPECT_EQ(line.angle_sign, line.pass % 2 == 1 ? -1 : 1);
  for (const SurveyLine& line : lines({"strip-offset=0.2"})) {
    EXPECT_GT(norm(line.offset), 0.0);
    EXPECT_LT(norm(line.offset), 1.5);
  }
}

TEST(Times, RollOverAtTheEndOfAWeekOnlyWhereAskedFor) {
  EXPECT_EQ(recorded_time({}, 307779200.25), 307779200.25);
  DefectOptions defects;
  defects.week_rollover = true;
  // 1307779200.25 s of GPS time are 2162 whole weeks and 201600.25 s.
  EXPECT_NEAR(recorded_time(defects, 307779200.25), 201600.25, 1e-6);
  EXPECT_LT(recorded_time(defects, 307779200.0 + kWeekS - 201600.0 + 1.0), 2.0);
}

}  // namespace
}  // namespace cornice::simulate
