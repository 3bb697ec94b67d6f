// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/camera_memory.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cornice::viewer {

void CameraMoves::see(const Camera& camera, double seconds) {
  if (camera != resting_) {
    resting_ = camera;
    still_s_ = 0.0;
    is_kept_ = false;
    return;
  }
  still_s_ += seconds;
  if (is_kept_ || still_s_ < kRestSeconds) return;
  history_.add(camera);
  is_kept_ = true;
}

void CameraMoves::jump(const Camera& camera) { history_.add(camera); }

Camera CameraMoves::undo(const Camera& present) {
  // A move that has not come to rest is the one to undo.
  history_.add(present);
  return history_.undo().value_or(present);
}

Camera CameraMoves::redo(const Camera& present) { return history_.redo().value_or(present); }

void PathMaker::add(const Camera& camera) {
  if (is_finished_) set({});
  is_finished_ = false;
  const double time = path_.keys.empty() ? 0.0 : path_.keys.back().time_s + kStepSeconds;
  path_.keys.push_back({time, camera});
}

void PathMaker::set(CameraPath path) {
  path_ = std::move(path);
  is_playing_ = false;
  is_finished_ = true;
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
  std::size_t number = bookmarks.size();
  std::string name;
  do {
    name = "view " + std::to_string(++number);
  } while (std::any_of(bookmarks.begin(), bookmarks.end(),
                       [&](const Bookmark& other) { return other.name == name; }));
  bookmarks.push_back({std::move(name), camera});
}

}  // namespace cornice::viewer
