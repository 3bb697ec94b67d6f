// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/index/box_finder.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace cornice::index {
namespace {

std::vector<std::size_t> by_asking_all(const std::vector<Box2d>& boxes, const Box2d& box) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (boxes[i].intersects(box)) found.push_back(i);
  return found;
}

void expect_all_found(const std::vector<Box2d>& boxes) {
  const BoxFinder finder(boxes);
  for (const Box2d& box : boxes)
    for (const double margin : {0.0, 40.0})
      EXPECT_EQ(finder.touching(box.grown(margin)), by_asking_all(boxes, box.grown(margin)));
}

TEST(BoxFinder, FindsWhatAskingAllBoxesFinds) {
  for (const double stretch : {0.05, 1.0, 20.0}) {  // a column, a square, a row of boxes
    std::vector<Box2d> boxes;
    for (std::uint64_t i = 0; i < 300; ++i) {
      CounterRandom random(7, 1, i);
      const double x = random.uniform(0.0, stretch * 1000.0), y = random.uniform(0.0, 1000.0);
      boxes.push_back({x, y, x + random.uniform(0.0, 60.0), y + random.uniform(0.0, 60.0)});
    }
    boxes.push_back({100, 100, 900, 900});  // far longer than the others
    boxes.push_back({500, 500, 500, 500});  // a point
    expect_all_found(boxes);
  }
}

TEST(BoxFinder, FindsBoxesThatShareABorderOrACorner) {
  const BoxFinder finder({{0, 0, 10, 10}, {10, 0, 20, 10}, {10, 10, 20, 20}, {20.1, 0, 30, 10}});
  EXPECT_EQ(finder.touching({0, 0, 10, 10}), (std::vector<std::size_t>{0, 1, 2}));
}

TEST(BoxFinder, FindsNothingAmongNothing) {
  EXPECT_TRUE(BoxFinder({}).touching({0, 0, 1, 1}).empty());
}

}  // namespace
}  // namespace cornice::index
