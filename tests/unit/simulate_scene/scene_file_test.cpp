// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"

namespace cornice::simulate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SceneFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) {
    test::write_text(folder_ / "scene.yaml", text);
    return folder_ / "scene.yaml";
  }
  /// The message of the InputError that reading `text` ends in.
  std::string error_of(const std::string& text) {
    try {
      read_scene_file(write(text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  test::TemporaryFolder folder_;
};

constexpr const char* kSmallest = "cornice_scene: 1\nname: plain\nbase_m: 100\n";

TEST_F(SceneFile, TheSmallestSceneIsAPlain) {
  const SceneDescription scene = read_scene_file(write(kSmallest));
  EXPECT_EQ(scene.name, "plain");
  EXPECT_EQ(scene.base_m, 100.0);
  EXPECT_TRUE(scene.walls.empty());
}

TEST_F(SceneFile, EverySampleSceneIsRead) {
  for (const char* name : {"alp", "cliff", "valley", "pass"}) {
    const SceneDescription scene =
        read_scene_file(std::filesystem::path(CORNICE_SOURCE_DIR) / "samples/scenes" /
                        (std::string(name) + ".yaml"));
    EXPECT_EQ(scene.name, name);
  }
}

TEST_F(SceneFile, AnUnknownKeyIsNamedWithItsLineAndTheKnownKeys) {
  const std::string message = error_of(std::string(kSmallest) + "hils: {height_m: 3}\n");
  EXPECT_THAT(message, AllOf(HasSubstr((folder_ / "scene.yaml").string()), HasSubstr("line 4"),
                             HasSubstr("hils"), HasSubstr("hills")));
}

TEST_F(SceneFile, AMissingKeyIsNamed) {
  EXPECT_THAT(error_of("cornice_scene: 1\nname: x\n"),
              AllOf(HasSubstr("base_m"), HasSubstr("missing")));
}

TEST_F(SceneFile, AValueOutOfRangeSaysWhatIsAccepted) {
  EXPECT_THAT(error_of(std::string(kSmallest) + "hills:\n  height_m: 20\n  wavelength_m: 2\n"),
              AllOf(HasSubstr("line 6"), HasSubstr("hills.wavelength_m"), HasSubstr("is 2"),
                    HasSubstr("[8, 20000]")));
}

TEST_F(SceneFile, TextWhereANumberIsWantedIsAnErrorAtItsLine) {
  EXPECT_THAT(error_of("cornice_scene: 1\nname: x\nbase_m: high\n"),
              AllOf(HasSubstr("line 3"), HasSubstr("base_m"), HasSubstr("must be a number")));
}

TEST_F(SceneFile, NotANumberIsRefused) {
  EXPECT_THAT(error_of("cornice_scene: 1\nname: x\nbase_m: .nan\n"), HasSubstr("must be a number"));
}

TEST_F(SceneFile, APlaceOfOneNumberIsRefused) {
  EXPECT_THAT(
      error_of(std::string(kSmallest) + "villages:\n  - {at: [3], radius_m: 20, houses: 2}\n"),
      AllOf(HasSubstr("line 5"), HasSubstr("villages.at"), HasSubstr("[east, north]")));
}

TEST_F(SceneFile, ARiverOfOnePlaceIsRefused) {
  EXPECT_THAT(error_of(std::string(kSmallest) +
                       "rivers:\n  - {course: [[0, 0]], width_m: 9, bank_m: 9, level_m: 0}\n"),
              AllOf(HasSubstr("rivers.course"), HasSubstr("at least 2")));
}

TEST_F(SceneFile, BrokenYamlIsAnErrorAtItsLine) {
  EXPECT_THAT(error_of("cornice_scene: 1\nname: [x\n"),
              AllOf(HasSubstr("line"), HasSubstr("YAML")));
}

TEST_F(SceneFile, AListAtTheTopIsRefused) {
  EXPECT_THAT(error_of("- 1\n- 2\n"), HasSubstr("mapping"));
}

TEST_F(SceneFile, AnEmptyFileIsRefused) { EXPECT_THAT(error_of(""), HasSubstr("mapping")); }

TEST_F(SceneFile, AMissingFileIsRefused) {
  EXPECT_THROW(read_scene_file("/nowhere/scene.yaml"), InputError);
}

TEST_F(SceneFile, AnotherVersionIsRefused) {
  EXPECT_THAT(error_of("cornice_scene: 2\nname: x\nbase_m: 0\n"), HasSubstr("cornice_scene"));
}

TEST(AzimuthDirection, CountsClockwiseFromNorth) {
  EXPECT_NEAR(azimuth_direction(0).y, 1.0, 1e-12);
  EXPECT_NEAR(azimuth_direction(90).x, 1.0, 1e-12);
  EXPECT_NEAR(azimuth_direction(180).y, -1.0, 1e-12);
}

}  // namespace
}  // namespace cornice::simulate
