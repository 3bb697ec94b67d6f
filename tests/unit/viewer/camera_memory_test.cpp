// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/camera_memory.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cornice::viewer {
namespace {

Camera camera_at(double x) { return {{x, 10.0, 500.0}, 30.0, -20.0, 50.0}; }

/// From one place to another in ten frames, then rest.
void move(CameraMoves& moves, double from, double to, double rest_s = 0.4, double frame_s = 0.016) {
  for (int frame = 1; frame <= 10; ++frame)
    moves.see(camera_at(from + 0.1 * frame * (to - from)), frame_s);
  for (double s = 0.0; s < rest_s; s += frame_s) moves.see(camera_at(to), frame_s);
}

TEST(CameraMoves, AreUndoneAndDoneAgainFromRestToRest) {
  CameraMoves moves;
  moves.jump(camera_at(0.0));
  move(moves, 0.0, 100.0);
  move(moves, 100.0, 300.0);
  EXPECT_EQ(moves.undo(camera_at(300.0)), camera_at(100.0));
  EXPECT_EQ(moves.undo(camera_at(100.0)), camera_at(0.0));
  EXPECT_EQ(moves.undo(camera_at(0.0)), camera_at(0.0)) << "there is nothing before the first";
  EXPECT_EQ(moves.redo(camera_at(0.0)), camera_at(100.0));
  EXPECT_EQ(moves.redo(camera_at(100.0)), camera_at(300.0));
  EXPECT_EQ(moves.redo(camera_at(300.0)), camera_at(300.0)) << "there is nothing after the last";
}

TEST(CameraMoves, AreUndoneBeforeTheyHaveComeToRest) {
  CameraMoves moves;
  moves.jump(camera_at(0.0));
  move(moves, 0.0, 100.0);
  move(moves, 100.0, 160.0, 0.05);
  EXPECT_EQ(moves.undo(camera_at(160.0)), camera_at(100.0));
  EXPECT_EQ(moves.redo(camera_at(100.0)), camera_at(160.0));
}

TEST(CameraMoves, AreToldApartByRestHoweverLongFramesAre) {
  for (const double frame_s : {0.004, 0.016, 0.25}) {
    CameraMoves moves;
    moves.jump(camera_at(0.0));
    move(moves, 0.0, 100.0, 0.6, frame_s);
    move(moves, 100.0, 300.0, 0.6, frame_s);
    EXPECT_EQ(moves.undo(camera_at(300.0)), camera_at(100.0)) << frame_s;
    EXPECT_EQ(moves.undo(camera_at(100.0)), camera_at(0.0)) << frame_s;
  }
}

TEST(CameraMoves, AreToldApartByANewGraspWithoutRest) {
  CameraMoves moves;
  moves.jump(camera_at(0.0));
  moves.begin(camera_at(0.0));
  move(moves, 0.0, 100.0, 0.0);
  moves.begin(camera_at(100.0));
  move(moves, 100.0, 300.0, 0.0);
  EXPECT_EQ(moves.undo(camera_at(300.0)), camera_at(100.0));
  EXPECT_EQ(moves.undo(camera_at(100.0)), camera_at(0.0));
}

TEST(CameraMoves, ForgetWhatWasUndoneWhenTheCameraGoesElsewhere) {
  CameraMoves moves;
  moves.jump(camera_at(0.0));
  move(moves, 0.0, 100.0);
  EXPECT_EQ(moves.undo(camera_at(100.0)), camera_at(0.0));
  // Standing where undo led to is no move.
  for (int frame = 0; frame < 50; ++frame) moves.see(camera_at(0.0), 0.016);
  EXPECT_EQ(moves.redo(camera_at(0.0)), camera_at(100.0));
  EXPECT_EQ(moves.undo(camera_at(100.0)), camera_at(0.0));
  move(moves, 0.0, -50.0);
  EXPECT_EQ(moves.redo(camera_at(-50.0)), camera_at(-50.0));
  EXPECT_EQ(moves.undo(camera_at(-50.0)), camera_at(0.0));
}

TEST(PathMaker, PlaysThroughAllItsViewsAndEndsAtTheLast) {
  PathMaker path;
  for (const double x : {0.0, 40.0, 70.0}) path.add(camera_at(x));
  ASSERT_EQ(path.size(), 3u);
  EXPECT_DOUBLE_EQ(path.path().duration_s(), 2.0 * PathMaker::kStepSeconds);
  path.toggle_play();
  ASSERT_TRUE(path.is_playing());
  double before = -1e-9;
  int frames = 0;
  Camera last;
  while (path.is_playing()) {
    last = path.play(1.0 / 32.0);
    ++frames;
    EXPECT_GE(last.eye.x, before) << "never goes back";
    before = last.eye.x;
    if (frames == static_cast<int>(32.0 * PathMaker::kStepSeconds)) {
      EXPECT_NEAR(last.eye.x, 40.0, 1e-9);
    }
  }
  EXPECT_EQ(last, camera_at(70.0));
  EXPECT_EQ(frames, static_cast<int>(64.0 * PathMaker::kStepSeconds));
}

TEST(PathMaker, StopsWhenAskedAndBeginsAgainAtTheStart) {
  PathMaker path;
  path.add(camera_at(5.0));
  path.toggle_play();
  EXPECT_FALSE(path.is_playing()) << "one view is no path";
  path.add(camera_at(9.0));
  path.toggle_play();
  path.play(2.0);
  path.toggle_play();
  EXPECT_FALSE(path.is_playing());
  path.toggle_play();
  EXPECT_NEAR(path.play(1e-9).eye.x, 5.0, 1e-6);
  path.stop();
  EXPECT_FALSE(path.is_playing());
  EXPECT_EQ(path.size(), 2u);
}

TEST(PathMaker, PlaysWhatIsSavedAndBeginsAnotherWithTheNextView) {
  PathMaker path;
  path.add(camera_at(1.0));
  path.add(camera_at(2.0));
  path.finish();
  path.toggle_play();
  EXPECT_TRUE(path.is_playing());
  path.add(camera_at(3.0));
  EXPECT_EQ(path.size(), 1u) << "what is saved is not changed behind its file";
  path.add(camera_at(4.0));
  EXPECT_EQ(path.size(), 2u);
  CameraPath read;
  read.keys = {{0.0, camera_at(5.0)}, {1.0, camera_at(6.0)}};
  path.set(read);
  path.add(camera_at(7.0));
  EXPECT_EQ(path.size(), 1u) << "nor what came from a file";
}

TEST(Bookmarks, GetTheNextName) {
  std::vector<Bookmark> bookmarks;
  add_bookmark(bookmarks, camera_at(1.0));
  add_bookmark(bookmarks, camera_at(2.0));
  ASSERT_EQ(bookmarks.size(), 2u);
  EXPECT_EQ(bookmarks[0].name, "view 1");
  EXPECT_EQ(bookmarks[1].name, "view 2");
  EXPECT_EQ(bookmarks[1].camera, camera_at(2.0));
  bookmarks.erase(bookmarks.begin());
  add_bookmark(bookmarks, camera_at(3.0));
  EXPECT_EQ(bookmarks[1].name, "view 3") << "no name twice";
}

}  // namespace
}  // namespace cornice::viewer
