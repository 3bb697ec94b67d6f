// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/pilot.h"

#include <utility>

#include "core/base/error.h"
#include "terrain-viewer/app/new_file.h"

namespace cornice::viewer {

Pilot::Pilot(const Camera& start, double speed_ms, std::filesystem::path path_file)
    : camera_(start), path_file_(std::move(path_file)) {
  controls_.speed_ms = speed_ms;
  moves_.jump(start);
}

std::string Pilot::step(const ControlInput& input, const Surroundings& around) {
  if (asks_to_move(input)) path_.stop();
  const bool plays = path_.is_playing();
  if (input.pressed || input.is_double_click) moves_.begin(camera_);
  if (path_.is_playing()) {
    controls_.walks = false;
    camera_ = path_.play(input.seconds);
  }
  camera_ = controls_.step(camera_, input, around.point, around.ground);
  moves_.see(camera_, input.seconds);
  const bool played = std::exchange(was_playing_, path_.is_playing());
  if (plays && !path_.is_playing()) return "the path has ended; Ctrl+P plays it again";
  return played && !plays ? "stopped" : "";
}

void Pilot::go(const Camera& camera) {
  path_.stop();
  moves_.jump(camera_);
  camera_ = camera;
  moves_.jump(camera_);
}

std::string Pilot::toggle_walk(const Surroundings& around) {
  const auto camera = controls_.toggle_walk(camera_, around.point, around.ground);
  if (!camera) return "there is no ground to walk on below the eye or under the cursor";
  if (*camera != camera_) go(*camera);
  return controls_.walks ? "walking; Space flies again" : "flying";
}

std::string Pilot::add_to_path() {
  path_.add(camera_);
  return std::to_string(path_.size()) + " view" + (path_.size() > 1 ? "s" : "") +
         " in the path; Shift+P saves it, Ctrl+P plays it";
}

std::string Pilot::save_path(const std::filesystem::path& folder) {
  if (path_.size() == 0) return "there is no path to save; P adds this view to one";
  const std::string name = unused_stem(folder, "cornice-path-" + time_stamp(), {".json"}) + ".json";
  write_camera_path(folder / name, path_.path());
  path_.finish();
  return "path written: " + name;
}

std::string Pilot::toggle_play() {
  if (path_.is_playing()) {
    path_.stop();
    return "stopped";
  }
  if (path_.size() == 0 && !path_file_.empty()) path_.set(read_camera_path(path_file_));
  if (path_.size() < 2) return "a path needs two views to be played; P adds this one";
  moves_.begin(camera_);
  path_.toggle_play();
  return "playing " + std::to_string(path_.size()) + " views; Ctrl+P stops";
}

std::optional<std::string> Pilot::heed(Action action, const Surroundings& around,
                                       const std::filesystem::path& folder) {
  try {
    switch (action) {
      case Action::kUndo:
        path_.stop();
        camera_ = moves_.undo(camera_);
        return "";
      case Action::kRedo:
        path_.stop();
        camera_ = moves_.redo(camera_);
        return "";
      case Action::kWalk:
        return toggle_walk(around);
      case Action::kSeeAll:
        controls_.walks = false;
        go(seeing_all(camera_, around.lowest, around.highest, around.width_over_height));
        return "";
      case Action::kAddToPath:
        return add_to_path();
      case Action::kSavePath:
        return save_path(folder);
      case Action::kPlayPath:
        return toggle_play();
      default:
        return std::nullopt;
    }
  } catch (const Error& error) {
    // A file that cannot be read or written ends what was asked for, not the window.
    return error.what();
  }
}

}  // namespace cornice::viewer
