// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/scene/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/base/error.h"
#include "core/base/random.h"
#include "terrain-viewer/scene/camera_file.h"
#include "tests/support/temporary_folder.h"

namespace cornice::viewer {
namespace {

constexpr int kWidth = 640, kHeight = 480;

/// Pixel of a point by the matrix that the GPU gets.
Vec3d pixel_by_matrix(const Camera& camera, Vec3d point) {
  const Matrix4 m = view_projection(camera, double(kWidth) / kHeight, 0.5);
  const Vec3d p = point - camera.eye;
  const auto row = [&](std::size_t r) {
    return m[r] * p.x + m[4 + r] * p.y + m[8 + r] * p.z + m[12 + r];
  };
  const double w = row(3);
  return {(row(0) / w + 1.0) * 0.5 * kWidth - 0.5, (1.0 - row(1) / w) * 0.5 * kHeight - 0.5,
          row(2) / w};
}

TEST(Camera, LooksNorthAlongTheHorizonByDefault) {
  const CameraAxes axes = axes_of(Camera{});
  EXPECT_NEAR(axes.forward.y, 1.0, 1e-12);
  EXPECT_NEAR(axes.right.x, 1.0, 1e-12);
  EXPECT_NEAR(axes.up.z, 1.0, 1e-12);
}

TEST(Camera, SeesThePointThatTheRayOfAPixelLeadsToInThatPixel) {
  Camera camera;
  camera.eye = {2643500.0, 1158000.0, 2400.0};
  for (int turn = 0; turn < 24; ++turn) {
    camera.heading_deg = 15.0 * turn;
    camera.pitch_deg = -80.0 + 6.0 * turn;
    camera.field_of_view_deg = 20.0 + 4.0 * turn;
    const double x = 11.0 * turn, y = 470.0 - 17.0 * turn;
    const Vec3d point = camera.eye + 1234.5 * ray_of_pixel(camera, kWidth, kHeight, x, y);
    const auto pixel = pixel_of_point(camera, kWidth, kHeight, point);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x, x, 1e-6);
    EXPECT_NEAR(pixel->y, y, 1e-6);
    const Vec3d on_gpu = pixel_by_matrix(camera, point);
    EXPECT_NEAR(on_gpu.x, x, 1e-2);
    EXPECT_NEAR(on_gpu.y, y, 1e-2);
    EXPECT_NEAR(on_gpu.z, 0.5 / pixel->z, 1e-6) << "depth is near over distance";
  }
}

TEST(Camera, LookingAtAPointHasItInTheMiddle) {
  const Camera camera = looking_at(Camera{}, {100.0, 200.0, 300.0}, {-40.0, 260.0, 180.0});
  const auto pixel = pixel_of_point(camera, kWidth, kHeight, {-40.0, 260.0, 180.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, 0.5 * kWidth - 0.5, 1e-6);
  EXPECT_NEAR(pixel->y, 0.5 * kHeight - 0.5, 1e-6);
  EXPECT_FALSE(pixel_of_point(camera, kWidth, kHeight, {240.0, 140.0, 420.0}));
}

TEST(Camera, TurnsTheShorterWayRound) {
  Camera a, b;
  a.heading_deg = 350.0;
  b.heading_deg = 20.0;
  EXPECT_NEAR(between(a, b, 0.5).heading_deg, 5.0, 1e-9);
  EXPECT_NEAR(between(b, a, 1.0).heading_deg, 350.0, 1e-9);
}

class CameraFiles : public testing::Test {
 protected:
  std::string problem(const std::string& text, bool is_path) const {
    std::ofstream(folder_ / "bad.json") << text;
    try {
      if (is_path)
        read_camera_path(folder_ / "bad.json");
      else
        read_camera(folder_ / "bad.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  test::TemporaryFolder folder_;
};

TEST_F(CameraFiles, ComeBackAsTheyWere) {
  const Camera camera{{2643500.125, 1158000.5, 2400.75}, 123.25, -12.5, 50.0};
  write_camera(folder_ / "a.json", camera);
  EXPECT_EQ(read_camera(folder_ / "a.json"), camera);
  CameraPath path;
  path.keys = {{0.0, camera}, {2.5, looking_at(camera, {0, 0, 0}, {5, 5, 5})}};
  path.frames_per_second = 24.0;
  write_camera_path(folder_ / "p.json", path);
  const CameraPath back = read_camera_path(folder_ / "p.json");
  ASSERT_EQ(back.keys.size(), 2u);
  EXPECT_EQ(back.keys[1].camera, path.keys[1].camera);
  EXPECT_EQ(back.frames_per_second, 24.0);
}

TEST_F(CameraFiles, AreRefusedByTheNameOfTheWrongKey) {
  EXPECT_NE(problem("{", false).find("JSON"), std::string::npos);
  EXPECT_NE(problem("{\"eye\":[1,2]}", false).find("eye"), std::string::npos);
  EXPECT_NE(problem("{\"eye\":[1,2,3],\"heading_deg\":0,\"pitch_deg\":95}", false).find("pitch"),
            std::string::npos);
  EXPECT_NE(problem("{\"keys\":[]}", true).find("keys"), std::string::npos);
  const std::string key =
      "\"eye\":[1,2,3],\"heading_deg\":0,\"pitch_deg\":0,\"field_of_view_deg\":45}";
  EXPECT_NE(problem("{\"keys\":[{\"time_s\":1," + key + ",{\"time_s\":1," + key + "]}", true)
                .find("rise"),
            std::string::npos);
}

TEST_F(CameraFiles, SayInOneLineWhichFieldIsWrongAndWhatItShouldBe) {
  struct Case {
    const char *field, *value, *remedy;
  };
  const std::vector<Case> cases{{"eye", "3", "[easting, northing, height]"},
                                {"eye", "[1,2]", "[easting, northing, height]"},
                                {"eye", "[1,2,\"3\"]", "[easting, northing, height]"},
                                {"eye", "[1,2,1e30]", "100,000 km"},
                                {"heading_deg", "null", "-360.0 to 360.0"},
                                {"heading_deg", "361", "-360.0 to 360.0"},
                                {"pitch_deg", "\"down\"", "-90.0 to 90.0"},
                                {"pitch_deg", "-90.5", "-90.0 to 90.0"},
                                {"field_of_view_deg", "0", "1.0 to 150.0"},
                                {"field_of_view_deg", "179", "1.0 to 150.0"},
                                {"time_s", "-1", "0.0 to 1000000.0"},
                                {"time_s", "[]", "0.0 to 1000000.0"},
                                {"time_s", "", "0.0 to 1000000.0"},
                                {"field_of_view_deg", "", "1.0 to 150.0"},
                                {"eye", "", "[easting, northing, height]"}};
  for (const Case& c : cases) {
    // One object with that field wrong, or without it.
    std::string object;
    for (const auto& [field, value] :
         std::vector<std::pair<std::string, std::string>>{{"eye", "[1,2,3]"},
                                                          {"heading_deg", "0"},
                                                          {"pitch_deg", "0"},
                                                          {"field_of_view_deg", "45"},
                                                          {"time_s", "2"}}) {
      const std::string text = field == c.field ? c.value : value;
      if (!text.empty()) object += (object.empty() ? "\"" : ",\"") + field + "\":" + text;
    }
    const bool of_path_alone = std::string(c.field) == "time_s";
    for (const bool is_path : {false, true}) {
      if (of_path_alone && !is_path) continue;
      const std::string good =
          "{\"time_s\":1,\"eye\":[1,2,3],\"heading_deg\":0,\"pitch_deg\":0,\"field_of_view_deg\":"
          "45}";
      const std::string said = problem(
          is_path ? "{\"keys\":[" + good + ",{" + object + "}]}" : "{" + object + "}", is_path);
      const std::string name = (is_path ? "keys[1]." : "") + std::string(c.field);
      EXPECT_NE(said.find("bad.json"), std::string::npos) << said;
      EXPECT_NE(said.find("\"" + name + "\""), std::string::npos) << said;
      EXPECT_NE(said.find(c.remedy), std::string::npos) << said;
      EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
  }
  EXPECT_NE(problem("{\"keys\":[7]}", true).find("\"keys[0]\" is to be an object"),
            std::string::npos);
  EXPECT_NE(problem("[]", false).find("\"field_of_view_deg\""), std::string::npos);
}

TEST_F(CameraFiles, AreNoFolders) {
  for (const bool is_path : {false, true}) {
    try {
      is_path ? void(read_camera_path(folder_.path())) : void(read_camera(folder_.path()));
      FAIL() << "no error";
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()),
                folder_.path().string() + ": is a folder, not a file; give a file in it");
    }
  }
}

TEST(CameraPath, OfOneKeyStaysThereAndOfTwoGoesStraight) {
  CameraPath path;
  path.keys.push_back({2.0, {{10.0, 20.0, 30.0}, 350.0, -10.0, 40.0}});
  EXPECT_EQ(path.duration_s(), 0.0);
  for (const double time : {0.0, 2.0, 9.0}) EXPECT_EQ(path.at(time), path.keys[0].camera);
  path.keys.push_back({6.0, {{50.0, 20.0, 70.0}, 10.0, -30.0, 60.0}});
  EXPECT_EQ(path.duration_s(), 4.0);
  for (const double part : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    const Camera camera = path.at(2.0 + 4.0 * part);
    EXPECT_NEAR(camera.eye.y, 20.0, 1e-9);
    EXPECT_NEAR(camera.eye.x - 10.0, camera.eye.z - 30.0, 1e-9) << "on the line";
    EXPECT_NEAR(std::remainder(camera.heading_deg - (350.0 + 20.0 * part), 360.0), 0.0, 1e-9);
    EXPECT_NEAR(camera.field_of_view_deg, 40.0 + 20.0 * part, 1e-9);
  }
}

TEST(CameraPath, PassesThroughItsKeysWithoutAJump) {
  CameraPath path;
  for (int i = 0; i < 6; ++i) {
    Camera camera;
    camera.eye = {CounterRandom(7, 0, std::uint64_t(i)).uniform() * 100.0, i * 40.0,
                  10.0 * (i % 2)};
    path.keys.push_back({0.5 * i + (i > 2 ? 1.0 : 0.0), camera});
  }
  for (const CameraPath::Key& key : path.keys)
    EXPECT_LT(norm(path.at(key.time_s).eye - key.camera.eye), 1e-9);
  Vec3d before = path.at(0.0).eye;
  Vec3d step_before = path.at(1e-3).eye - before;
  for (double t = 1e-3; t < path.keys.back().time_s; t += 1e-3) {
    const Vec3d here = path.at(t).eye;
    EXPECT_LT(norm(here - before), 1.0) << t;
    EXPECT_LT(norm((here - before) - step_before), 0.02) << "speed jumps at " << t;
    step_before = here - before;
    before = here;
  }
}

}  // namespace
}  // namespace cornice::viewer
