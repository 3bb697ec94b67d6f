// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/info/wording.h"

#include <gtest/gtest.h>

namespace cornice::info {
namespace {

TEST(Wording, GroupsDigitsByThree) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(20400000), "20,400,000");
  EXPECT_EQ(counted(1, "point"), "1 point");
  EXPECT_EQ(counted(2, "point"), "2 points");
}

TEST(Wording, GivesTheDateOfGpsTimes) {
  // 2020-09-14 00:00:00 UTC is GPS second 1284076818, adjusted 284076818.
  EXPECT_EQ(date_of(284076818.0, TimeKind::kAdjustedStandard), "2020-09-14");
  EXPECT_EQ(date_of(284076817.0, TimeKind::kAdjustedStandard), "2020-09-13");
  EXPECT_EQ(date_of(1284076818.0, TimeKind::kStandard), "2020-09-14");
  EXPECT_EQ(date_of(1000.0, TimeKind::kWeekSeconds), "");
  EXPECT_EQ(date_of(1e300, TimeKind::kStandard), "");
}

TEST(Wording, NamesUnitsAndClasses) {
  EXPECT_EQ(unit_name(1.0), "metres");
  EXPECT_EQ(unit_name(0.3048), "feet");
  EXPECT_EQ(unit_name(1200.0 / 3937.0), "US survey feet");
  EXPECT_EQ(unit_name(0.0), "degrees");
  EXPECT_EQ(class_name(2), "2 ground");
  EXPECT_EQ(class_name(66), "66 virtual");
  EXPECT_EQ(class_name(200), "200");
}

TEST(Wording, ShowsAsManyDigitsAsAStepNeeds) {
  EXPECT_EQ(digits_of_step(0.01), 2);
  EXPECT_EQ(digits_of_step(0.001), 3);
  EXPECT_EQ(digits_of_step(0.00025), 4);
  EXPECT_EQ(digits_of_step(1.0), 0);
  EXPECT_EQ(digits_of_step(10.0), 0);
  EXPECT_EQ(digits_of_step(1e-20), 9);
  EXPECT_EQ(digits_of_step(0.0), 3);
}

}  // namespace
}  // namespace cornice::info
