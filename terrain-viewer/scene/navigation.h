// SPDX-License-Identifier: GPL-3.0-or-later
// What keys and the mouse do to a camera: pure functions, no window.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "terrain-viewer/scene/camera.h"

namespace cornice::viewer {

/// Which way to fly, each from -1 to 1, relative to the line of sight.
struct FlyInput {
  double forward = 0.0, right = 0.0, up = 0.0;
};

/// The camera after flying for seconds_s at speed_ms metres a second.
Camera fly(const Camera& camera, const FlyInput& input, double speed_ms, double seconds_s);

/// The camera after walking: level, whatever it looks at, and without going up.
Camera walk(const Camera& camera, const FlyInput& input, double speed_ms, double seconds_s);

/// Turned on the spot; pitch stays within +-89.9 degrees so that the view never rolls over.
Camera turn(const Camera& camera, double heading_deg, double pitch_deg);

/// Turned with the eye around `pivot`, which stays where it is in the picture.
Camera orbit(const Camera& camera, Vec3d pivot, double heading_deg, double pitch_deg);

/// Moved so that the point `grabbed` comes under the pixel (x, y) without coming nearer.
Camera pan(const Camera& camera, Vec3d grabbed, int width, int height, double x, double y);

/// Moved along the line to `target` to `factor` times the distance; the target stays in its pixel.
Camera zoom(const Camera& camera, Vec3d target, double factor, double nearest_m = 0.5);

/// Height of the ground in plan; nothing where there is none.
using Ground = std::function<std::optional<double>(double x, double y)>;

/// Raised to `clearance_m` above the ground where it is lower.
Camera above_ground(const Camera& camera, const Ground& ground, double clearance_m);

/// Put at `eye_height_m` above the ground, for walking; unchanged where there is no ground.
Camera on_ground(const Camera& camera, const Ground& ground, double eye_height_m);

/// The camera that sees a whole box from the south, tilted down.
Camera seeing_all(const Camera& like, Vec3d lowest, Vec3d highest, double width_over_height);

/// Undo and redo of camera moves: one entry for each move, however many frames it took.
class CameraHistory {
 public:
  /// A move ended at `camera`; what was undone before is forgotten.
  void add(const Camera& camera);
  std::optional<Camera> undo();
  std::optional<Camera> redo();

 private:
  static constexpr std::size_t kLimit = 200;
  std::vector<Camera> cameras_;
  std::size_t present_ = 0;
};

/// "2643500 1158000", "2643500, 1158000, 2400" (projected, metres) or "46.5N 8.1E", "46.5 8.1"
/// (latitude and longitude in degrees: values that fit the globe). z is empty where not given.
struct PlaceText {
  double first = 0.0, second = 0.0;  ///< easting and northing, or latitude and longitude
  std::optional<double> z;
  bool is_globe = false;
};
std::optional<PlaceText> parse_place(const std::string& text);

}  // namespace cornice::viewer
