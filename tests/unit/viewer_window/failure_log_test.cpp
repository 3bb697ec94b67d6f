// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/failure_log.h"

#include <gtest/gtest.h>

namespace cornice::viewer {
namespace {

TEST(FailureLog, TellsAFewInFullAndCountsTheRest) {
  FailureLog log;
  EXPECT_EQ(log.line(), "");
  EXPECT_EQ(log.add({"a: cell 1"}).size(), 1u);
  EXPECT_NE(log.line().find("a: cell 1"), std::string::npos);
  EXPECT_EQ(log.line().find("such"), std::string::npos) << "one is none of many";
  const std::vector<std::string> many(1000, "b: cell 2");
  EXPECT_EQ(log.add(many).size(), FailureLog::kMostInFull - 1);
  EXPECT_NE(log.line().find("(1001 such)"), std::string::npos) << log.line();
  EXPECT_TRUE(log.add(many).empty());
  EXPECT_EQ(log.untold(), 2001u - FailureLog::kMostInFull);
}

TEST(FailureLog, LeavesItsLineWhereNothingFailed) {
  FailureLog log;
  log.add({"a"});
  const std::string before = log.line();
  EXPECT_TRUE(log.add({}).empty());
  EXPECT_EQ(log.line(), before);
  EXPECT_EQ(log.untold(), 0u);
}

}  // namespace
}  // namespace cornice::viewer
