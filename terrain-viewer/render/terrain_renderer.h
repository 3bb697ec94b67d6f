// SPDX-License-Identifier: GPL-3.0-or-later
// Draws cells that lie on the GPU: decoded, morphed and shaded by the shaders.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hlod/file.h"
#include "hlod/morph.h"
#include "terrain-viewer/render/drape_texture.h"
#include "terrain-viewer/render/gpu_cells.h"
#include "terrain-viewer/scene/camera.h"
#include "terrain-viewer/scene/style.h"

namespace cornice::viewer {

/// Cells of one hierarchy, the nearest first.
struct DrawList {
  const hlod::Header* header = nullptr;
  const std::vector<hlod::Node>* nodes = nullptr;
  hlod::FinePoint eye;                 ///< hlod::fine_eye of the camera
  std::int32_t slab_distance = 0;      ///< hlod::slab_distance
  std::vector<hlod::MorphBand> bands;  ///< by level; those of levels in use, but for level 0
  struct Item {
    std::uint32_t row = 0;  ///< of the nodes
    GpuCell cell;
  };
  std::vector<Item> items;
};

/// A part of the picture left or right of a pixel column.
struct Swipe {
  double column = 0.0;
  int side = 0;  ///< 0: the whole picture; -1: left of the column; 1: right of it
};

struct DrawCounts {
  std::uint64_t triangles = 0;
  std::uint32_t cells = 0;
  std::uint32_t calls = 0;
};

class TerrainRenderer {
 public:
  TerrainRenderer();
  ~TerrainRenderer();
  TerrainRenderer(const TerrainRenderer&) = delete;
  TerrainRenderer& operator=(const TerrainRenderer&) = delete;

  /// Clears the target and draws the sky, or `clear_colour` where there is one.
  /// The picture is the part of the framebuffer from pixel column `left` on.
  void begin(GLuint framebuffer, int width, int height, const Camera& camera, const Style& style,
             const Colour* clear_colour = nullptr, int left = 0);
  /// What lies over all that is drawn from now on; null: nothing. Must live as long as that.
  void set_drape(DrapeTexture* drape);
  /// Draws one hierarchy over what is there. begin comes first.
  DrawCounts draw(const DrawList& list, const GpuCells& cells, const Style& style,
                  const Swipe& swipe = {});
  /// After all that is drawn in the shading kOverdraw: shows it. Returns Overdraw::show().
  double show_overdraw();
  /// Writes where the vertex shader puts the first `count` vertices of the list's first cell, three
  /// floats each, metres from the eye, into a buffer: for tests of the shader itself. begin comes
  /// first.
  void place(const DrawList& list, const GpuCells& cells, std::size_t count, GLuint places);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornice::viewer
