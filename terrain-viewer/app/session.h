// SPDX-License-Identifier: GPL-3.0-or-later
// One scene on one OpenGL context: its layers, its look, and a frame of it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "terrain-viewer/app/scene_setup.h"
#include "terrain-viewer/render/drape.h"
#include "terrain-viewer/render/terrain_renderer.h"

namespace cornice::viewer {

/// How a layer is shown among the others; drawn in the order of the list.
struct LayerLook {
  bool is_visible = true;
  double opacity = 1.0;
};

/// What lies over the ground's own colours.
enum class Cover { kNone, kPhoto, kDifference };

/// What one frame took.
struct FrameCounts {
  double select_ms = 0.0;  ///< choosing, reading out of the store, upload
  std::uint64_t triangles = 0;
  std::uint32_t cells = 0, calls = 0, missing = 0;
  DrapeCounts drape;
  std::uint64_t uploaded_bytes = 0;
  bool is_settled = true;  ///< nothing that the view needs is missing
};

/// For the thread of the context, which must be current.
class Session {
 public:
  /// Throws as open_layers, style_for and Drape.
  explicit Session(const Options& options);

  Layers& layers() { return layers_; }
  std::vector<LayerLook>& looks() { return looks_; }
  Style& style() { return style_; }
  const GpuCells& cells() const { return cells_; }
  double& error_pixels() { return options_.error_pixels; }
  /// Adds a file as the last layer. Throws as open_layers.
  void add_layer(const std::filesystem::path& file);
  /// Lays rasters over the ground, as photograph or differences, in place of those before, and
  /// shows them. Throws as Drape.
  void add_drape(const std::vector<std::filesystem::path>& files, RasterKind kind);
  /// Null where none has been added.
  const Drape* photo() const { return photo_.get(); }
  const Drape* difference() const { return difference_.get(); }
  /// Which of both is shown; kNone where that one is not there.
  Cover cover() const;
  void set_cover(Cover cover) { cover_ = cover; }

  /// Draws into a framebuffer. seconds since the frame before; 0: waits for all that it needs.
  /// swipe_column: from this pixel column on the last visible layer is drawn, left of it the
  /// others; below 0: all layers everywhere.
  FrameCounts draw(GLuint framebuffer, int width, int height, const Camera& camera, double seconds,
                   Vec3d velocity, double swipe_column = -1.0);
  /// Messages about cells and tiles that could not be read since the last call.
  std::vector<std::string> take_failures();

 private:
  Drape* shown_drape() const;
  void update_drape(const LayerView& view, FrameCounts& counts);

  Options options_;
  TerrainRenderer renderer_;
  GpuCells cells_;
  Layers layers_;
  std::vector<LayerLook> looks_;
  Style style_;
  std::unique_ptr<Drape> photo_, difference_;
  Cover cover_ = Cover::kNone;
  std::uint64_t frame_ = 0;
};

}  // namespace cornice::viewer
