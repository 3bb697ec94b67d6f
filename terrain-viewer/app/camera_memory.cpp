// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/camera_memory.h"

#include <cassert>
#include <utility>

namespace cornice::viewer {

void CameraMoves::see(const Camera& camera) {
  if (camera == resting_) {
    if (++still_frames_ == kRestFrames) history_.add(camera);
  } else {
    still_frames_ = 0;
    resting_ = camera;
  }
}

void CameraMoves::jump(const Camera& camera) { history_.add(camera); }

Camera CameraMoves::undo(const Camera& present) {
  // A move that has not come to rest is the one to undo.
  history_.add(present);
  return history_.undo().value_or(present);
}

Camera CameraMoves::redo(const Camera& present) { return history_.redo().value_or(present); }

void PathMaker::add(const Camera& camera) {
  const double time = path_.keys.empty() ? 0.0 : path_.keys.back().time_s + kStepSeconds;
  path_.keys.push_back({time, camera});
}

void PathMaker::clear() { set({}); }

void PathMaker::set(CameraPath path) {
  path_ = std::move(path);
  is_playing_ = false;
}

void PathMaker::toggle_play() {
  is_playing_ = !is_playing_ && path_.keys.size() > 1;
  played_s_ = 0.0;
}

Camera PathMaker::play(double seconds) {
  assert(is_playing_);
  played_s_ += seconds;
  is_playing_ = played_s_ < path_.duration_s();
  return path_.at(path_.keys.front().time_s + played_s_);
}

void add_bookmark(std::vector<Bookmark>& bookmarks, const Camera& camera) {
  bookmarks.push_back({"view " + std::to_string(bookmarks.size() + 1), camera});
}

}  // namespace cornice::viewer
