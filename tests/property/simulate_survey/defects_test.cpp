// SPDX-License-Identifier: GPL-3.0-or-later
// Every defect does what it says to a whole survey, and nothing else.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "core/points/point_cloud.h"
#include "property/simulate_survey/flown.h"

namespace cornice::test {
namespace {

using namespace simulate;

class Defect : public testing::Test {
 protected:
  Defect() : options_(small_survey()) {
    options_.tiles = "1x1";
    options_.tile_m = 60.0;
    options_.flight.cross_line = true;
    scene_ = scene_for(options_);
    scene_.canopy_west = scene_.extent.min_x + 60.0;
    scene_.canopy_east = scene_.extent.max_x;
    scene_.slope_x = 0.3;
    scene_.wall_x = scene_.extent.min_x + 80.0;
    scene_.wall_height = 25.0;
    clean_ = points_with({});
  }
  std::vector<SurveyPoint> points_with(const std::vector<std::string>& defects) {
    options_.defects = defects;
    survey_ = std::make_unique<Survey>(options_, scene_);
    return points_of(*survey_);
  }
  /// Every point equals the clean one but for what `undo` gives back.
  void expect_same_but(const std::vector<SurveyPoint>& spoiled,
                       const std::function<void(SurveyPoint&, const SurveyPoint&)>& undo) {
    ASSERT_EQ(spoiled.size(), clean_.size());
    for (std::size_t i = 0; i < clean_.size(); ++i) {
      SurveyPoint point = spoiled[i];
      undo(point, clean_[i]);
      ASSERT_TRUE(equal(point, clean_[i])) << i;
    }
  }
  static bool equal(const SurveyPoint& a, const SurveyPoint& b) {
    return a.gps_time_s == b.gps_time_s && a.at == b.at && a.scan_angle_deg == b.scan_angle_deg &&
           a.true_offset == b.true_offset && a.normal == b.normal && a.beam == b.beam &&
           a.intensity == b.intensity && a.point_source_id == b.point_source_id &&
           a.line == b.line && a.return_number == b.return_number &&
           a.return_count == b.return_count && a.classification == b.classification &&
           a.flags == b.flags && a.channel == b.channel && a.user_data == b.user_data &&
           a.surface == b.surface;
  }
  SurveyOptions options_;
  PlaneScene scene_;
  std::unique_ptr<Survey> survey_;
  std::vector<SurveyPoint> clean_;
};

TEST_F(Defect, ReversedAnglesChangeTheSignAndNothingElse) {
  ASSERT_GT(clean_.size(), 10000u);
  expect_same_but(points_with({"reversed-angle"}),
                  [](SurveyPoint& p, const SurveyPoint&) { p.scan_angle_deg *= -1.0f; });
  std::set<int> reversed;
  expect_same_but(points_with({"reversed-angle-alternate"}),
                  [&](SurveyPoint& p, const SurveyPoint& clean) {
                    if (p.scan_angle_deg == clean.scan_angle_deg) return;
                    reversed.insert(p.line);
                    p.scan_angle_deg *= -1.0f;
                  });
  EXPECT_EQ(reversed, (std::set<int>{2}));
}

TEST_F(Defect, WholeDegreesRoundTheAngleAndNothingElse) {
  expect_same_but(points_with({"whole-degrees"}), [](SurveyPoint& p, const SurveyPoint& clean) {
    EXPECT_EQ(p.scan_angle_deg, std::round(p.scan_angle_deg));
    EXPECT_NEAR(p.scan_angle_deg, clean.scan_angle_deg, 0.5);
    p.scan_angle_deg = clean.scan_angle_deg;
  });
}

TEST_F(Defect, SourceIdsAreZeroedOrReusedAndNothingElse) {
  expect_same_but(points_with({"zeroed-source-ids"}), [](SurveyPoint& p, const SurveyPoint& clean) {
    EXPECT_EQ(p.point_source_id, 0);
    p.point_source_id = clean.point_source_id;
  });
  std::map<int, std::set<int>> lines_of_id;
  expect_same_but(points_with({"reused-source-ids"}),
                  [&](SurveyPoint& p, const SurveyPoint& clean) {
                    lines_of_id[p.point_source_id].insert(p.line);
                    p.point_source_id = clean.point_source_id;
                  });
  EXPECT_EQ(lines_of_id.begin()->second.size(), 2u);
}

TEST_F(Defect, ZeroTimesLoseTheTimeOfTheirShareAndNothingElse) {
  int lost = 0;
  expect_same_but(points_with({"zero-times=0.1"}), [&](SurveyPoint& p, const SurveyPoint& clean) {
    if (p.gps_time_s != 0.0) return;
    ++lost;
    p.gps_time_s = clean.gps_time_s;
  });
  EXPECT_NEAR(lost / static_cast<double>(clean_.size()), 0.1, 0.02);
}

TEST_F(Defect, ReturnNumbersOfTheirShareOfPulsesAreWrongAndNothingElse) {
  int wrong = 0;
  expect_same_but(points_with({"return-numbers=0.2"}),
                  [&](SurveyPoint& p, const SurveyPoint& clean) {
                    wrong += p.return_number != clean.return_number ? 1 : 0;
                    p.return_number = clean.return_number;
                  });
  EXPECT_GT(wrong, static_cast<int>(0.1 * static_cast<double>(clean_.size())));
  EXPECT_LT(wrong, static_cast<int>(0.3 * static_cast<double>(clean_.size())));
}

TEST_F(Defect, DuplicatePointsAreAddedAndNothingElse) {
  const std::vector<SurveyPoint> spoiled = points_with({"duplicate-points=0.1"});
  EXPECT_NEAR(static_cast<double>(spoiled.size()), 1.1 * static_cast<double>(clean_.size()),
              0.02 * static_cast<double>(clean_.size()));
  // Without the second of each pair of copies the clean survey is left.
  std::size_t next = 0;
  for (const SurveyPoint& point : spoiled)
    if (next < clean_.size() && equal(point, clean_[next])) ++next;
  EXPECT_EQ(next, clean_.size());
}

TEST_F(Defect, AbsurdAnglesComeWithTheirFlagAndNothingElse) {
  int absurd = 0;
  expect_same_but(points_with({"absurd-angles=0.05"}),
                  [&](SurveyPoint& p, const SurveyPoint& clean) {
                    if (p.flags == clean.flags) return;
                    ++absurd;
                    EXPECT_GE(std::abs(p.scan_angle_deg), 75.0f);
                    p.scan_angle_deg = clean.scan_angle_deg;
                    p.flags = clean.flags;
                  });
  EXPECT_NEAR(absurd / static_cast<double>(clean_.size()), 0.05, 0.015);
}

TEST_F(Defect, MisclassifiedRockIsSteepAndKeepsAllElse) {
  int wrong = 0, steep = 0;
  expect_same_but(points_with({"misclassified=0.5"}),
                  [&](SurveyPoint& p, const SurveyPoint& clean) {
                    const bool is_rock = clean.normal.z < 0.5f && clean.classification == 2;
                    steep += is_rock ? 1 : 0;
                    if (p.classification == clean.classification) return;
                    EXPECT_TRUE(is_rock);
                    ++wrong;
                    p.classification = clean.classification;
                  });
  ASSERT_GT(steep, 100);
  EXPECT_NEAR(wrong / static_cast<double>(steep), 0.5, 0.1);
}

TEST_F(Defect, OutliersStayOnTheirBeamFarFromTheSurfaceAndTheOthersStayWhereTheyAre) {
  const std::vector<SurveyPoint> spoiled = points_with({"outliers=0.05"});
  std::size_t same = 0, far = 0;
  std::map<std::pair<double, int>, const SurveyPoint*> clean_at;
  for (const SurveyPoint& p : clean_) clean_at[{p.gps_time_s, p.return_number}] = &p;
  for (const SurveyPoint& p : spoiled) {
    const auto found = clean_at.find({p.gps_time_s, p.return_number});
    if (p.surface == kNoSurface) {
      ++far;
      const Vec3d way = p.recorded() - sensor_of(*survey_, p);
      EXPECT_LT(norm(cross(way, p.beam.cast<double>())), 0.2);
      if (found != clean_at.end()) {
        EXPECT_GT(norm(p.recorded() - found->second->recorded()), 4.8);
      }
    } else {
      ASSERT_TRUE(found != clean_at.end());
      EXPECT_TRUE(equal(p, *found->second));
      ++same;
    }
  }
  EXPECT_NEAR(static_cast<double>(far) / static_cast<double>(clean_.size()), 0.05, 0.02);
  EXPECT_GT(same, 9 * clean_.size() / 10);
}

TEST_F(Defect, StripOffsetsMoveEachLineAsAWhole) {
  const std::vector<SurveyPoint> spoiled = points_with({"strip-offset=0.3"});
  std::map<std::pair<double, int>, const SurveyPoint*> clean_at;
  for (const SurveyPoint& p : clean_) clean_at[{p.gps_time_s, p.return_number}] = &p;
  std::size_t found_again = 0;
  for (const SurveyPoint& p : spoiled) {
    const auto found = clean_at.find({p.gps_time_s, p.return_number});
    if (found == clean_at.end()) continue;
    ++found_again;
    const Vec3d moved = p.recorded() - found->second->recorded();
    const Vec3d offset = survey_->setup.lines[p.line - 1u].offset;
    ASSERT_LT(norm(moved - offset), 0.02);
    ASSERT_LT(norm(p.truth() - found->second->truth()), 1e-4) << "truth does not move";
    ASSERT_EQ(p.scan_angle_deg, found->second->scan_angle_deg);
  }
  EXPECT_GT(found_again, 9 * clean_.size() / 10);
  EXPECT_NE(survey_->setup.lines[0].offset, survey_->setup.lines[1].offset);
}

TEST_F(Defect, TimesOfTheWeekStartAnewInTheFirstLine) {
  const std::vector<SurveyPoint> spoiled = points_with({"week-rollover"});
  bool is_before = false, is_after = false;
  for (const SurveyPoint& p : spoiled) {
    EXPECT_GE(p.gps_time_s, 0.0);
    EXPECT_LT(p.gps_time_s, kWeekS);
    if (p.line != 1) continue;
    is_before |= p.gps_time_s > kWeekS - 100.0;
    is_after |= p.gps_time_s < 100.0;
  }
  EXPECT_TRUE(is_before && is_after);
  EXPECT_NEAR(static_cast<double>(spoiled.size()), static_cast<double>(clean_.size()),
              0.02 * static_cast<double>(clean_.size()));
}

TEST_F(Defect, TheSecondSurveyComesFortyFourDaysLaterUnderTheSameIds) {
  const std::vector<SurveyPoint> spoiled = points_with({"two-surveys"});
  std::map<int, std::pair<double, double>> span_of_id;
  for (const SurveyPoint& p : spoiled) {
    auto [at, is_new] = span_of_id.try_emplace(p.point_source_id, p.gps_time_s, p.gps_time_s);
    at->second.second = p.gps_time_s;
  }
  EXPECT_GT(span_of_id.begin()->second.second - span_of_id.begin()->second.first, 43.0 * 86400.0);
}

TEST_F(Defect, VirtualPointsHaveNoTimeLineAngleOrReturn) {
  points_with({"virtual-points"});
  const std::vector<SurveyPoint> points = virtual_points(survey_->setup, 0);
  ASSERT_EQ(points.size(), 144u);
  for (const SurveyPoint& p : points) {
    EXPECT_EQ(p.classification, 66);
    EXPECT_EQ(p.gps_time_s, 0.0);
    EXPECT_EQ(p.point_source_id, 0);
    EXPECT_EQ(p.scan_angle_deg, 0.0f);
    EXPECT_EQ(p.return_number, 0);
    EXPECT_EQ(p.line, 0);
  }
  expect_same_but(points_of(*survey_), [](SurveyPoint&, const SurveyPoint&) {});
}

TEST_F(Defect, VirtualPointsOfLidarHdLieOnWaterOnly) {
  options_.product = SurveyProduct::kLidarHd;
  options_.corner = {2746000.0, 1234000.0};
  points_with({});
  EXPECT_TRUE(virtual_points(survey_->setup, 0).empty());
  scene_.water_west = scene_.extent.min_x + 30.0;
  scene_.water_east = scene_.extent.min_x + 50.0;
  points_with({});
  EXPECT_EQ(virtual_points(survey_->setup, 0).size(), 48u);
  points_with({"none"});
  EXPECT_TRUE(virtual_points(survey_->setup, 0).empty());
}

}  // namespace
}  // namespace cornice::test
