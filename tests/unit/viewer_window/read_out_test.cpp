// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/read_out.h"

#include <gtest/gtest.h>

namespace cornice::viewer {
namespace {

TEST(ReadOutText, GivesThePlaceInTheScenesSystemAndOnTheGlobe) {
  ReadOut read_out("EPSG:2056+5728");
  EXPECT_EQ(read_out.text({}), "sky");
  // The old observatory of Bern by the formulas of swisstopo: 7 26 19.08 E, 46 57 3.90 N (WGS 84).
  const std::string text = read_out.text(UnderCursor{{2'600'000.0, 1'200'000.0, 549.5}, 12.4});
  EXPECT_EQ(text, "E 2600000.00  N 1200000.00  H 549.50 m   slope 12 deg\n46.951083 N  7.438632 E");
  EXPECT_EQ(read_out.text({}), "sky");
}

TEST(ReadOutText, SaysNothingOfTheGlobeWithoutAReferenceSystem) {
  ReadOut read_out("");
  EXPECT_EQ(read_out.text(UnderCursor{{1.0, 2.0, 3.0}, {}}), "E 1.00  N 2.00  H 3.00 m");
}

TEST(ReadOutText, ChangesWithThePlace) {
  ReadOut read_out("EPSG:2154");
  const std::string first = read_out.text(UnderCursor{{700'000.0, 6'600'000.0, 1.0}, {}});
  EXPECT_NE(first.find("46.500000 N  3.000000 E"), std::string::npos) << first;
  const std::string second = read_out.text(UnderCursor{{700'000.0, 6'600'100.0, 1.0}, {}});
  EXPECT_NE(second, first);
}

}  // namespace
}  // namespace cornice::viewer
