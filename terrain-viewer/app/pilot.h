// SPDX-License-Identifier: GPL-3.0-or-later
// The camera of a window and all that moves it: hands, keys, undo, a path that is played. Knows no
// window.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "terrain-viewer/app/camera_memory.h"
#include "terrain-viewer/app/controls.h"
#include "terrain-viewer/app/key_actions.h"

namespace cornice::viewer {

/// What moves of the camera ask the scene for.
struct Surroundings {
  std::function<std::optional<Vec3d>()> point;  ///< the ground under the cursor
  Ground ground;
  Vec3d lowest, highest;  ///< box of all
  double width_over_height = 1.0;
};

class Pilot {
 public:
  /// path_file: what to play where no path is made, or empty.
  Pilot(const Camera& start, double speed_ms, std::filesystem::path path_file);

  const Camera& camera() const { return camera_; }
  bool walks() const { return controls_.walks; }
  double speed() const { return controls_.speed(); }
  bool is_playing() const { return path_.is_playing(); }
  /// True where steps without input leave the camera as it is and all moves are remembered.
  bool is_at_rest() const { return !path_.is_playing() && moves_.is_at_rest(); }

  /// One frame. A path that plays stops where hands take hold of the camera. Returns what to say,
  /// empty for nothing.
  std::string step(const ControlInput& input, const Surroundings& around);
  /// At once; undo leads back.
  void go(const Camera& camera);
  /// What to say of an action of the camera, empty for nothing; no value where it is none. Paths
  /// are saved into `folder`.
  std::optional<std::string> heed(Action action, const Surroundings& around,
                                  const std::filesystem::path& folder);

 private:
  std::string toggle_walk(const Surroundings& around);
  std::string add_to_path();
  std::string save_path(const std::filesystem::path& folder);
  std::string toggle_play();

  Camera camera_;
  Controls controls_;
  CameraMoves moves_;
  PathMaker path_;
  std::filesystem::path path_file_;
  bool was_playing_ = false;  ///< after the frame before
};

}  // namespace cornice::viewer
