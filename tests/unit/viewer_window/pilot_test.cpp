// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/pilot.h"

#include <gtest/gtest.h>

#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"

namespace cornice::viewer {
namespace {

constexpr double kGroundM = 100.0, kFrameS = 0.02;

Camera start() { return {{0.0, 0.0, 500.0}, 0.0, -30.0, 50.0}; }
Camera at_x(double x) { return {{x, 0.0, 500.0}, 0.0, -30.0, 50.0}; }

/// Flat ground everywhere, and the point under the cursor 300 m ahead.
Surroundings flat() {
  return {[] {
            return Vec3d{0.0, 300.0, kGroundM};
          },
          [](double, double) { return std::optional(kGroundM); },
          {-500.0, -500.0, kGroundM},
          {500.0, 500.0, 200.0},
          1.5};
}
Surroundings nothing() {
  Surroundings around = flat();
  around.point = [] { return std::optional<Vec3d>(); };
  around.ground = [](double, double) { return std::optional<double>(); };
  return around;
}
ControlInput still() {
  ControlInput in;
  in.seconds = kFrameS;
  in.width = 800;
  in.height = 600;
  return in;
}
void rest(Pilot& pilot) {
  for (int i = 0; i < 30; ++i) pilot.step(still(), flat());
}
std::string heed(Pilot& pilot, Action action, const Surroundings& around = flat()) {
  return pilot.heed(action, around, "/nowhere").value_or("not its own");
}

TEST(Pilot, LandsOnTheGroundBelowAndWalksAtEyeHeightAndLevel) {
  Pilot pilot(start(), 50.0, {});
  heed(pilot, Action::kWalk);
  EXPECT_TRUE(pilot.walks());
  EXPECT_DOUBLE_EQ(pilot.camera().eye.z, kGroundM + 1.7);
  EXPECT_GT(pilot.camera().pitch_deg, -20.0) << "looks ahead, not at its feet";
  ControlInput ahead = still();
  ahead.fly.forward = 1.0;
  ahead.fly.up = 1.0;
  const double before = pilot.camera().eye.y;
  for (int i = 0; i < 50; ++i) pilot.step(ahead, flat());
  EXPECT_NEAR(pilot.camera().eye.y - before, 50 * kFrameS * pilot.speed(), 1e-9);
  EXPECT_DOUBLE_EQ(pilot.camera().eye.z, kGroundM + 1.7);
  EXPECT_LT(pilot.speed(), 10.0) << "on foot";
  heed(pilot, Action::kWalk);
  EXPECT_FALSE(pilot.walks());
  EXPECT_EQ(pilot.speed(), 50.0);
}

TEST(Pilot, LandsWhereTheCursorIsBesideTheGroundAndNowhereOverNothing) {
  Surroundings beside = flat();
  beside.ground = [](double, double y) {
    return y > 100.0 ? std::optional(kGroundM) : std::nullopt;
  };
  Pilot pilot(start(), 50.0, {});
  heed(pilot, Action::kWalk, beside);
  EXPECT_TRUE(pilot.walks());
  EXPECT_DOUBLE_EQ(pilot.camera().eye.y, 300.0);
  EXPECT_DOUBLE_EQ(pilot.camera().eye.z, kGroundM + 1.7);
  Pilot lost(start(), 50.0, {});
  EXPECT_NE(heed(lost, Action::kWalk, nothing()).find("no ground"), std::string::npos);
  EXPECT_FALSE(lost.walks());
  EXPECT_EQ(lost.camera(), start());
}

TEST(Pilot, TakesEachDragForAMoveOfItsOwn) {
  Pilot pilot(start(), 50.0, {});
  const auto drag = [&](double dx) {
    ControlInput in = still();
    in.middle = in.pressed = true;
    pilot.step(in, flat());
    in.pressed = false;
    in.dx = dx;
    pilot.step(in, flat());
    pilot.step(still(), flat());
    return pilot.camera();
  };
  const Camera first = drag(40.0), second = drag(80.0);
  EXPECT_NE(first, second);
  heed(pilot, Action::kUndo);
  EXPECT_EQ(pilot.camera(), first);
  heed(pilot, Action::kUndo);
  EXPECT_EQ(pilot.camera(), start());
  heed(pilot, Action::kUndo);
  EXPECT_EQ(pilot.camera(), start()) << "nothing before the first";
  heed(pilot, Action::kRedo);
  heed(pilot, Action::kRedo);
  EXPECT_EQ(pilot.camera(), second);
}

TEST(Pilot, HomeAndPlacesAreUndone) {
  Pilot pilot(start(), 50.0, {});
  heed(pilot, Action::kSeeAll);
  const Camera all = pilot.camera();
  EXPECT_NE(all, start());
  pilot.go(at_x(77.0));
  heed(pilot, Action::kUndo);
  EXPECT_EQ(pilot.camera(), all);
  heed(pilot, Action::kUndo);
  EXPECT_EQ(pilot.camera(), start());
}

TEST(Pilot, PlaysThePathThatIsMadeUntilItsEnd) {
  Pilot pilot(at_x(0.0), 50.0, {});
  heed(pilot, Action::kAddToPath);
  pilot.go(at_x(60.0));
  heed(pilot, Action::kAddToPath);
  pilot.go(at_x(500.0));
  heed(pilot, Action::kPlayPath);
  EXPECT_TRUE(pilot.is_playing());
  pilot.step(still(), nothing());
  EXPECT_NEAR(pilot.camera().eye.x, 0.0, 2.0);
  std::string said;
  for (int i = 0; i < 1000 && pilot.is_playing(); ++i) {
    EXPECT_EQ(said, "");
    EXPECT_FALSE(pilot.is_at_rest());
    said = pilot.step(still(), nothing());
  }
  EXPECT_FALSE(pilot.is_playing());
  EXPECT_NE(said.find("ended"), std::string::npos) << said;
  EXPECT_EQ(pilot.step(still(), nothing()), "");
  EXPECT_EQ(pilot.camera(), at_x(60.0));
  rest(pilot);
  EXPECT_TRUE(pilot.is_at_rest());
  heed(pilot, Action::kUndo);
  EXPECT_EQ(pilot.camera(), at_x(500.0)) << "a play is one move";
}

TEST(Pilot, StopsPlayingWhereAHandTakesHold) {
  for (int hand = 0; hand < 4; ++hand) {
    Pilot pilot(at_x(0.0), 50.0, {});
    heed(pilot, Action::kAddToPath);
    pilot.go(at_x(60.0));
    heed(pilot, Action::kAddToPath);
    heed(pilot, Action::kPlayPath);
    pilot.step(still(), nothing());
    ControlInput in = still();
    if (hand == 0) in.pressed = in.left = true;
    if (hand == 1) in.fly.right = 1.0;
    if (hand == 2) in.wheel = 1.0;
    if (hand == 3) heed(pilot, Action::kSeeAll);
    EXPECT_EQ(pilot.step(in, nothing()), "stopped") << hand;
    EXPECT_FALSE(pilot.is_playing()) << hand;
  }
}

TEST(Pilot, PlaysThePathOfTheCommandLineAndSaysWhyItCannot) {
  const test::TemporaryFolder folder;
  CameraPath path;
  path.keys = {{0.0, at_x(10.0)}, {2.0, at_x(20.0)}};
  write_camera_path(folder / "path.json", path);
  Pilot pilot(start(), 50.0, folder / "path.json");
  heed(pilot, Action::kPlayPath);
  ASSERT_TRUE(pilot.is_playing());
  pilot.step(still(), nothing());
  EXPECT_NEAR(pilot.camera().eye.x, 10.0, 1.0);
  Pilot damaged(start(), 50.0, folder / "none.json");
  EXPECT_NE(heed(damaged, Action::kPlayPath).find("none.json"), std::string::npos);
  EXPECT_FALSE(damaged.is_playing());
  Pilot without(start(), 50.0, {});
  EXPECT_NE(heed(without, Action::kPlayPath).find("two views"), std::string::npos);
}

TEST(Pilot, SavesPathsUnderNamesOfTheirOwn) {
  const test::TemporaryFolder folder;
  Pilot pilot(start(), 50.0, {});
  const auto save = [&] { return *pilot.heed(Action::kSavePath, flat(), folder.path()); };
  EXPECT_NE(save().find("no path"), std::string::npos);
  heed(pilot, Action::kAddToPath);
  // However many of a second there are.
  for (int i = 0; i < 4; ++i) EXPECT_NE(save().find("path written:"), std::string::npos);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_EQ(read_camera_path(entry.path()).keys.size(), 1u);
    ++files;
  }
  EXPECT_EQ(files, 4u);
}

TEST(Pilot, LivesOnWhereAPathCannotBeWritten) {
  const test::TemporaryFolder folder;
  test::write_text(folder / "file", "");
  Pilot pilot(start(), 50.0, {});
  heed(pilot, Action::kAddToPath);
  const auto message = pilot.heed(Action::kSavePath, flat(), folder / "file");
  ASSERT_TRUE(message);
  EXPECT_NE(message->find("cornice-path-"), std::string::npos) << *message;
  EXPECT_EQ(message->find("path written:"), std::string::npos) << *message;
  EXPECT_NE(pilot.heed(Action::kSavePath, flat(), folder.path())->find("path written:"),
            std::string::npos)
      << "it is still there to be saved";
}

TEST(Pilot, LivesOnWhereTheDiskIsFull) {
  const test::TemporaryFolder folder;
  const auto outcome = test::on_full_disk(folder.path(), [&] {
    test::write_text(folder / "rest", std::string(64 << 10, 'x'));
    Pilot pilot(start(), 50.0, {});
    heed(pilot, Action::kAddToPath);
    const auto message = pilot.heed(Action::kSavePath, flat(), folder.path());
    if (message->find("path written:") != std::string::npos)
      test::write_text(folder / "wrong", *message);
  });
  if (!outcome) GTEST_SKIP() << "this machine lets nobody mount a small disk";
  EXPECT_EQ(*outcome, "|rest");
}

TEST(Pilot, LeavesOtherActionsToOthers) {
  Pilot pilot(start(), 50.0, {});
  for (const Action action : {Action::kHelp, Action::kNextShading, Action::kGoTo, Action::kQuit})
    EXPECT_FALSE(pilot.heed(action, flat(), "."));
}

}  // namespace
}  // namespace cornice::viewer
