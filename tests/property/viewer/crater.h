// SPDX-License-Identifier: GPL-3.0-or-later
// A crater with an overhanging cliff across it, and a studio to draw it in: from within, nothing
// but ground is seen, so that every pixel of another colour is a hole.
#pragma once

#include <filesystem>

#include "core/io/raster.h"
#include "core/mesh/mesh.h"
#include "hlod/cell.h"
#include "terrain-viewer/render/gl.h"
#include "terrain-viewer/render/layer.h"
#include "terrain-viewer/render/offscreen_context.h"

namespace cornice::viewer {

inline constexpr double kCraterM = 240.0;  ///< side; its corner is at (0, 0, 0) of `crater_origin`
Vec3d crater_origin();

/// 200,000 triangles.
Mesh crater_mesh();
/// Of them; cells of 1500.
void write_crater(const std::filesystem::path& path,
                  hlod::Partition partition = hlod::Partition::kQuadtree);

/// On a closed curve through the crater, low over the ground and down the cliff; t: 0..1.
Camera crater_camera(double t);

inline constexpr Colour kMagenta{255, 0, 255};

/// One hierarchy drawn without a window, over magenta, in plain colours.
class CraterStudio {
 public:
  struct Budgets {
    std::uint64_t gpu_bytes = 256u << 20, cache_bytes = 256u << 20;
    int threads = 1;
    std::uint64_t page_bytes = 64u << 20;
  };
  CraterStudio(const std::filesystem::path& file, int width, int height, const Budgets& budgets);

  LayerView view(const Camera& camera, double error_pixels) const;
  Picture draw(const DrawList& list, const Camera& camera);
  /// Waits for all that the view takes; false where it is not to be had.
  bool settle(const Camera& camera, double error_pixels);
  /// As a window draws: what is loaded in time.
  void update(const Camera& camera, double error_pixels, double seconds);

  Layer& layer() { return layer_; }
  const GpuCells& cells() const { return cells_; }

 private:
  OffscreenContext context_;
  GpuCells cells_;
  Layer layer_;
  TerrainRenderer renderer_;
  Target target_;
  std::uint64_t frame_ = 0;
};

/// The list with every vertex at its own place, whatever its distance.
DrawList without_morphing(const DrawList& list);

}  // namespace cornice::viewer
