// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/go_to.h"

#include <gtest/gtest.h>

#include <string>

namespace cornice::viewer {
namespace {

const std::string kSwiss = "EPSG:2056+5728", kFrench = "EPSG:2154+5720";

void expect_place(const std::string& text, const std::string& crs, double x, double y,
                  double off_m) {
  const PlaceFound found = find_place(text, crs);
  ASSERT_TRUE(found.place) << text << ": " << found.problem;
  EXPECT_TRUE(found.problem.empty());
  EXPECT_NEAR(found.place->x, x, off_m) << text;
  EXPECT_NEAR(found.place->y, y, off_m) << text;
}

TEST(GoTo, TakesCoordinatesOfTheSceneAsTheyAre) {
  expect_place("2643500 1158000", kSwiss, 2'643'500.0, 1'158'000.0, 0.0);
  expect_place("998250.5, 6536150", kFrench, 998'250.5, 6'536'150.0, 0.0);
  // Of no system that is known: those of the scene.
  expect_place("500000 4649776", "EPSG:32632", 500'000.0, 4'649'776.0, 0.0);
  expect_place("2643500 1158000", "", 2'643'500.0, 1'158'000.0, 0.0);
}

TEST(GoTo, FindsLatitudeAndLongitude) {
  // Where LV95 begins: the old observatory of Bern, in WGS 84 46 57' 03.898" N, 7 26' 19.077" E.
  expect_place("46.951083N 7.438633E", kSwiss, 2'600'000.0, 1'200'000.0, 3.0);
  expect_place("46.951083, 7.438633", kSwiss, 2'600'000.0, 1'200'000.0, 3.0);
  // Where Lambert-93 begins: 46 30' N, 3 E.
  expect_place("46.5N 3E", kFrench, 700'000.0, 6'600'000.0, 1e-3);
}

TEST(GoTo, ConvertsLv95AndLambert93WhereTheSceneHasTheOther) {
  // Mont Dolent, where three countries meet, in both systems.
  const PlaceFound here = find_place("45.92278N 7.04639E", kFrench);
  const PlaceFound there = find_place("45.92278N 7.04639E", kSwiss);
  ASSERT_TRUE(here.place && there.place);
  const auto text = [](const Vec3d& p) { return std::to_string(p.x) + " " + std::to_string(p.y); };
  expect_place(text(*there.place), kFrench, here.place->x, here.place->y, 0.01);
  expect_place(text(*here.place), kSwiss, there.place->x, there.place->y, 0.01);
  EXPECT_GT(here.place->x, 1'000'000.0);
  EXPECT_GT(there.place->x, 2'560'000.0);
}

TEST(GoTo, SaysInOneLineWhyThereIsNoPlace) {
  EXPECT_NE(find_place("there", kSwiss).problem.find("\"there\" is no place"), std::string::npos);
  EXPECT_NE(find_place("46.5 8.1", "").problem.find("reference system"), std::string::npos);
  for (const char* text : {"there", "46.5 8.1"}) EXPECT_FALSE(find_place(text, "").place);
}

TEST(GoTo, LooksAtTheGroundThereOrAtTheHeightThatIsGiven) {
  const Ground ground = [](double x, double) -> std::optional<double> {
    if (x > 2'700'000.0) return std::nullopt;
    return 1234.0;
  };
  const Camera like{{0.0, 0.0, 0.0}, 77.0, 0.0, 33.0};
  const auto target_height = [&](const std::string& text) {
    const PlaceFound found = find_place(text, kSwiss);
    const Camera camera = camera_over(found, like, ground, 4000.0);
    EXPECT_EQ(camera.field_of_view_deg, 33.0);
    const auto seen =
        pixel_of_point(camera, 641, 481, {found.place->x, found.place->y, camera.eye.z - 300.0});
    // In the very middle of the picture.
    EXPECT_TRUE(seen);
    if (seen) {
      EXPECT_NEAR(seen->x, 320.0, 1e-6);
      EXPECT_NEAR(seen->y, 240.0, 1e-6);
    }
    return camera.eye.z - 300.0;
  };
  EXPECT_EQ(target_height("2643500 1158000"), 1234.0);
  EXPECT_EQ(target_height("2643500 1158000 2000"), 2000.0);
  EXPECT_EQ(target_height("2743500 1158000"), 4000.0);
}

}  // namespace
}  // namespace cornice::viewer
