// SPDX-License-Identifier: GPL-3.0-or-later
// What a window remembers of cameras: moves to undo, bookmarks, a path that is made and played.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "terrain-viewer/scene/camera_file.h"
#include "terrain-viewer/scene/navigation.h"

namespace cornice::viewer {

struct Bookmark {
  std::string name;
  Camera camera;
};

/// Moves of the camera as people count them: one from rest to rest, however many frames it took.
class CameraMoves {
 public:
  /// So long without motion, and two frames at least, is rest.
  static constexpr double kRestSeconds = 0.35;

  /// Once a frame, which took so long.
  void see(const Camera& camera, double seconds);
  /// True once what was seen last has been at rest.
  bool is_at_rest() const { return is_kept_; }
  /// A hand takes hold of the camera: what came before was a move of its own, rest or not.
  void begin(const Camera& camera) { jump(camera); }
  /// The camera jumped: a move of its own.
  void jump(const Camera& camera);
  /// The camera before the last move, which may not have come to rest yet; `present` where there is
  /// none.
  Camera undo(const Camera& present);
  /// The camera after the move that was undone last; `present` where there is none.
  Camera redo(const Camera& present);

 private:
  CameraHistory history_;
  Camera resting_;
  double still_s_ = 0.0;
  bool is_kept_ = false;  ///< the camera at rest is in the history
};

/// A camera path that is put together view by view, and its playing.
class PathMaker {
 public:
  static constexpr double kStepSeconds = 3.0;  ///< from key to key

  /// Begins a new path where the one before is finished.
  void add(const Camera& camera);
  std::size_t size() const { return path_.keys.size(); }
  const CameraPath& path() const { return path_; }
  /// A finished path in place of what was made.
  void set(CameraPath path);
  /// It is written down: still to be played, but not added to.
  void finish() { is_finished_ = true; }
  /// Starts at the first key, or stops. A path of fewer than two keys does not play.
  void toggle_play();
  void stop() { is_playing_ = false; }
  bool is_playing() const { return is_playing_; }
  /// The camera `seconds` after the one before; at the path's end playing ends with its last key.
  /// Only while playing.
  Camera play(double seconds);

 private:
  CameraPath path_;
  bool is_playing_ = false, is_finished_ = false;
  double played_s_ = 0.0;
};

/// Appends the camera under the next name that is free: "view 1", "view 2".
void add_bookmark(std::vector<Bookmark>& bookmarks, const Camera& camera);

}  // namespace cornice::viewer
