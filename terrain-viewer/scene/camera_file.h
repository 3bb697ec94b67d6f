// SPDX-License-Identifier: GPL-3.0-or-later
// Cameras and camera paths as JSON files (docs/formats/camera.md).
#pragma once

#include <filesystem>
#include <vector>

#include "terrain-viewer/scene/camera.h"

namespace cornice::viewer {

/// Throws InputError for what is no camera, naming the key.
Camera read_camera(const std::filesystem::path& path);
void write_camera(const std::filesystem::path& path, const Camera& camera);

/// A flight: cameras at rising times.
struct CameraPath {
  struct Key {
    double time_s = 0.0;
    Camera camera;
  };
  std::vector<Key> keys;  ///< at least one, times strictly rising
  double frames_per_second = 30.0;

  double duration_s() const { return keys.back().time_s - keys.front().time_s; }
  /// Eyes on a Catmull-Rom curve through the keys; before the first and after the last key those.
  Camera at(double time_s) const;
};
CameraPath read_camera_path(const std::filesystem::path& path);
void write_camera_path(const std::filesystem::path& path, const CameraPath& cameras);

}  // namespace cornice::viewer
