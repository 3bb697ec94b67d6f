// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/swipe_line.h"

#include <gtest/gtest.h>

namespace cornice::viewer {
namespace {

constexpr double kWidth = 800.0;

LineMouse at(double x) { return {x, false, false, true, kWidth}; }
LineMouse press(double x) { return {x, true, true, true, kWidth}; }
LineMouse drag(double x) { return {x, false, true, true, kWidth}; }

TEST(SwipeLine, IsDraggedWithTheCursorWithoutAJump) {
  SwipeLine line;
  EXPECT_TRUE(line.step(press(404.0)));
  EXPECT_DOUBLE_EQ(line.share, 0.5) << "taken beside its middle";
  EXPECT_TRUE(line.step(drag(504.0)));
  EXPECT_DOUBLE_EQ(line.share, 500.0 / kWidth);
  line.step(drag(104.0));
  EXPECT_DOUBLE_EQ(line.share, 100.0 / kWidth);
  EXPECT_FALSE(line.step(at(300.0)));
  EXPECT_FALSE(line.is_dragged());
  EXPECT_DOUBLE_EQ(line.share, 100.0 / kWidth);
}

TEST(SwipeLine, HasTheMouseNearIt) {
  SwipeLine line;
  EXPECT_TRUE(line.step(at(400.0 - SwipeLine::kReachPixels)));
  EXPECT_TRUE(line.step(at(400.0 + SwipeLine::kReachPixels)));
  EXPECT_FALSE(line.step(at(400.0 - SwipeLine::kReachPixels - 1.0)));
  EXPECT_FALSE(line.step(at(400.0 + SwipeLine::kReachPixels + 1.0)));
}

TEST(SwipeLine, LeavesTheMouseToADragThatBeganElsewhereOrInAPanel) {
  SwipeLine line;
  EXPECT_FALSE(line.step(press(300.0)));
  EXPECT_FALSE(line.step(drag(400.0))) << "crosses it";
  EXPECT_DOUBLE_EQ(line.share, 0.5);
  line.step(at(300.0));
  LineMouse over_panel = press(400.0);
  over_panel.is_free = false;
  EXPECT_FALSE(line.step(over_panel));
  EXPECT_FALSE(line.step(drag(500.0)));
  EXPECT_DOUBLE_EQ(line.share, 0.5);
}

TEST(SwipeLine, KeepsTheDragOverAPanelAndStaysInThePicture) {
  SwipeLine line;
  line.step(press(400.0));
  LineMouse over_panel = drag(-50.0);
  over_panel.is_free = false;
  EXPECT_TRUE(line.step(over_panel));
  EXPECT_DOUBLE_EQ(line.share, 0.0);
  line.step(drag(5000.0));
  EXPECT_DOUBLE_EQ(line.share, 1.0);
  line.let_go();
  line.step(drag(200.0));
  EXPECT_DOUBLE_EQ(line.share, 1.0);
}

TEST(SwipeLine, IsTakenAgainWhereItWasLeftAtTheEdge) {
  SwipeLine line;
  line.share = 1.0;
  EXPECT_TRUE(line.step(press(kWidth - 1.0)));
  line.step(drag(kWidth - 101.0));
  EXPECT_DOUBLE_EQ(line.share, (kWidth - 100.0) / kWidth);
}

TEST(SideNames, SayWhatIsSetAgainstWhat) {
  const SideNames two = side_names({"dem.hlod", "lidar.hlod"}, "");
  EXPECT_EQ(two.left, "dem.hlod");
  EXPECT_EQ(two.right, "lidar.hlod");
  EXPECT_EQ(side_names({"a", "b", "c"}, "photograph p.tif").left, "a, b");
  EXPECT_EQ(side_names({"a", "b", "c"}, "photograph p.tif").right, "c");
  const SideNames one = side_names({"a"}, "differences d.tif");
  EXPECT_EQ(one.left, "a");
  EXPECT_EQ(one.right, "differences d.tif");
  EXPECT_EQ(side_names({}, "p.tif").left, "");
}

}  // namespace
}  // namespace cornice::viewer
