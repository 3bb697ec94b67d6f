// SPDX-License-Identifier: GPL-3.0-or-later
// One scene on one OpenGL context: its layers, its look, and a frame of it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "terrain-viewer/app/scene_setup.h"
#include "terrain-viewer/render/drape.h"
#include "terrain-viewer/render/gpu_timer.h"
#include "terrain-viewer/render/terrain_renderer.h"
#include "terrain-viewer/scene/frame_budget.h"

namespace cornice::viewer {

/// How a layer is shown among the others; drawn in the order of the list.
struct LayerLook {
  bool is_visible = true;
  double opacity = 1.0;
};

/// Two pictures of one view: the last visible layer against the others or, of a single layer, what
/// is draped over it against its own colours.
struct Split {
  enum class Kind { kNone, kSwipe, kSideBySide };
  Kind kind = Kind::kNone;
  double column = 0.0;  ///< of kSwipe: the second picture begins at this pixel column
};
/// Width of the one picture, or of each of two side by side.
inline int pane_width(int width, const Split& split) {
  return split.kind == Split::Kind::kSideBySide && width > 1 ? width / 2 : width;
}

/// What lies over the ground's own colours.
enum class Cover { kNone, kPhoto, kDifference };

/// What one frame took.
struct FrameCounts {
  double select_ms = 0.0;  ///< choosing, reading out of the store, upload
  std::uint64_t triangles = 0;
  std::uint32_t cells = 0, calls = 0, missing = 0;
  DrapeCounts drape;
  double error_pixels = 0.0;  ///< asked, or what the target for the time of a frame makes of it
  double draw_ms = 0.0;       ///< of the CPU or of the GPU some frames ago, whichever is longer
  double overdraw = 0.0;      ///< fragments per pixel drawn, in the shading of that name
  std::uint64_t uploaded_bytes = 0;
  bool is_settled = true;  ///< nothing that the view needs is missing
  /// The same view again would be the same picture, however much time passes. What is missing does
  /// not come for now.
  bool is_still = false;
};

/// For the thread of the context, which must be current.
class Session {
 public:
  /// Throws as open_layers, style_for and Drape.
  explicit Session(const Options& options);

  /// Has room on the GPU made before frames need it, by a thread that uses `context`, which shares
  /// with the session's and ends with it.
  void make_room_ahead(std::unique_ptr<SecondContext> context) {
    cells_.make_ahead(std::move(context));
  }

  Layers& layers() { return layers_; }
  std::vector<LayerLook>& looks() { return looks_; }
  Style& style() { return style_; }
  const Light& light() const { return light_; }
  void set_light(const Light& light);
  /// Where the scene is on the globe; nothing without a reference system.
  const std::optional<GlobePosition>& place() const { return place_; }
  const GpuCells& cells() const { return cells_; }
  double& error_pixels() { return options_.error_pixels; }
  /// Milliseconds that a frame may take; 0: no target.
  double& frame_ms() { return options_.frame_ms; }
  /// While true, what is drawn stays chosen as it is, wherever the camera goes.
  bool& is_frozen() { return is_frozen_; }
  /// Adds a file as the last layer. Throws as open_layers.
  void add_layer(const std::filesystem::path& file);
  /// Changes places in the order of drawing.
  void swap_layers(std::size_t i, std::size_t j);
  /// Shows one of the last two layers instead of the other.
  void blink();
  /// Lays rasters over the ground, as photograph or differences, in place of those before, and
  /// shows them. Throws as Drape.
  void add_drape(const std::vector<std::filesystem::path>& files, RasterKind kind);
  /// Null where none has been added.
  const Drape* photo() const { return photo_.get(); }
  const Drape* difference() const { return difference_.get(); }
  /// Which of both is shown; kNone where that one is not there.
  Cover cover() const;
  /// True where two pictures would differ: two visible layers, or something over one.
  bool can_split() const { return visible_count() > 1 || cover() != Cover::kNone; }
  void set_cover(Cover cover) { cover_ = cover; }

  /// Draws into a framebuffer. seconds since the frame before; 0: waits for all that it needs.
  FrameCounts draw(GLuint framebuffer, int width, int height, const Camera& camera, double seconds,
                   Vec3d velocity, const Split& split = {});
  /// The next frame does not follow the one before at once. GPUs slow down meanwhile: what it takes
  /// says nothing about the detail that there is time for.
  void pause() { is_after_pause_ = true; }
  /// Of the layer that has most.
  int level_count() const;
  /// One line that names visible layers without the values that the shading paints, which are drawn
  /// plain; empty where there are none.
  std::string missing_values() const;
  /// Messages about cells and tiles that could not be read since the last call.
  std::vector<std::string> take_failures();

 private:
  enum class Part { kWhole, kFirst, kSecond };  ///< of two pictures

  std::size_t last_visible() const;
  std::size_t visible_count() const;
  void choose(const LayerView& view, FrameCounts& counts);
  void draw_part(Part part, const Split& split, FrameCounts& counts);
  void draw_panes(GLuint framebuffer, const LayerView& view, const Split& split,
                  FrameCounts& counts);
  void heed_budget(double choose_ms, double seconds, FrameCounts& counts);
  bool changes(const LayerView& view, const Split& split, const FrameCounts& counts);
  Drape* shown_drape() const;
  void update_drape(const LayerView& view, FrameCounts& counts);

  Options options_;
  TerrainRenderer renderer_;
  GpuCells cells_;
  Layers layers_;
  std::vector<LayerLook> looks_;
  Style style_;
  std::optional<GlobePosition> place_;
  Light light_;
  std::unique_ptr<Drape> photo_, difference_;
  Cover cover_ = Cover::kNone;
  GpuTimer timer_;
  FrameBudget budget_;
  double gpu_ms_ = 0.0;
  bool is_frozen_ = false;
  LayerView drawn_view_;            ///< of the frame before
  std::vector<double> drawn_look_;  ///< likewise: levels, shading, what else a picture depends on
  bool came_to_rest_ = false;       ///< the frame before changed nothing
  bool is_after_pause_ = false;
  std::uint64_t frame_ = 0;
};

}  // namespace cornice::viewer
