// SPDX-License-Identifier: GPL-3.0-or-later
// Layers of one colour each, and a session that draws them without a window.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/io/raster.h"
#include "core/mesh/mesh.h"
#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/app/session.h"
#include "tests/support/hierarchy.h"
#include "tests/support/meshes.h"

namespace cornice::viewer {

inline constexpr double kPlateM = 100.0;
inline Vec3d plate_corner() { return {2'600'000.0, 1'200'000.0, 1000.0}; }

/// Ground of 100 m, all of it measured; its height over 1000 m and one colour for all of it.
inline void write_plate(const std::filesystem::path& path,
                        const std::function<double(double x, double y)>& height, Colour colour) {
  Mesh mesh = test::height_mesh(0.0, 0.0, 100, 1.0, height);
  mesh.origin = plate_corner();
  for (std::size_t c = 0; c < 3; ++c)
    mesh.byte_properties.push_back({std::array{"red", "green", "blue"}[c],
                                    std::vector<std::uint8_t>(mesh.positions.size(), colour[c])});
  mesh.float_properties.push_back({"support", std::vector<float>(mesh.positions.size(), 0.0f)});
  hlod::BuildOptions options;
  options.triangles_per_cell = 1000;
  test::write_hierarchy(path, mesh, options);
}

/// Straight above the middle of the plates, seeing nothing else.
inline Camera above_plates() {
  return {plate_corner() + Vec3d{0.5 * kPlateM, 0.5 * kPlateM, 60.0}, 0.0, -90.0, 40.0};
}

/// A session and what it draws into, of one sample.
class Desk {
 public:
  static constexpr int kWidth = 160, kHeight = 120;

  explicit Desk(const std::vector<std::filesystem::path>& files, double error_pixels = 2.0)
      : session_(options(files, error_pixels)), target_(kWidth, kHeight, 1) {}

  Session& session() { return session_; }
  const Target& target() const { return target_; }
  const FrameCounts& counts() const { return counts_; }
  Picture draw(const Camera& camera, const Split& split = {}) {
    counts_ = session_.draw(target_.framebuffer(), kWidth, kHeight, camera, 0.0, {}, split);
    return read_picture(target_);
  }
  /// The colour in the middle.
  Colour middle(const Camera& camera = above_plates()) {
    return draw(camera).pixels[std::size_t{kWidth} * (kHeight / 2) + kWidth / 2];
  }

 private:
  static Options options(const std::vector<std::filesystem::path>& files, double error_pixels) {
    Options options;
    options.files = files;
    options.shading = Shading::kColour;
    options.error_pixels = error_pixels;
    options.gpu_memory_mib = options.cache_mib = 32.0;
    return options;
  }
  Session session_;
  Target target_;
  FrameCounts counts_;
};

}  // namespace cornice::viewer
