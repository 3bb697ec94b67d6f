// SPDX-License-Identifier: GPL-3.0-or-later
// The overdraw ratio of scenes whose ratio is known.
#include <gtest/gtest.h>

#include <vector>

#include "terrain-viewer/render/gl.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "terrain-viewer/render/terrain_renderer.h"
#include "tests/unit/viewer_gpu/put_whole.h"

namespace cornice::viewer {
namespace {

constexpr int kWidth = 160, kHeight = 120;

/// Level plates of one metre a step, seen from 3000 m straight above (8000, 8000).
class Plates {
 public:
  Plates() {
    header_.lattice = {{0.0, 0.0, 0.0}, 16384.0, 0, 14};
    cells_.expect(64, 64);
  }
  void add(std::int32_t west, std::int32_t east, std::int32_t height) {
    hlod::CellMesh mesh;
    for (const std::int32_t y : {0, 16000})
      for (const std::int32_t x : {west, east}) {
        hlod::CellVertex v;
        v.position = {x, y, height};
        mesh.vertices.push_back(v);
      }
    mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
    const auto row = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back(hlod::make_node(mesh, 0.0f, 0.0f));
    std::vector<CellId> dropped;
    EXPECT_TRUE(put_whole(cells_, {0, row}, pack_cell(mesh, nodes_.back(), row), 1, dropped));
  }
  /// Drawn in this order.
  double overdraw(const std::vector<std::uint32_t>& rows) {
    Camera camera{{8000.0, 8000.0, 3000.0}, 0.0, -90.0, 40.0};
    DrawList list;
    list.header = &header_;
    list.nodes = &nodes_;
    list.eye = hlod::fine_eye(camera.eye, header_.lattice);
    for (const std::uint32_t row : rows) list.items.push_back({row, *cells_.use({0, row}, 2)});
    Style style;
    style.shading = Shading::kOverdraw;
    renderer_.begin(target_.framebuffer(), kWidth, kHeight, camera, style);
    renderer_.draw(list, cells_, style);
    return renderer_.show_overdraw();
  }

 private:
  OffscreenContext context_;
  TerrainRenderer renderer_;
  Target target_{kWidth, kHeight, 1};
  GpuCells cells_{1 << 20};
  hlod::Header header_;
  std::vector<hlod::Node> nodes_;
};

TEST(Overdraw, IsOneAndAHalfWhereAPlateOverHalfTheViewIsDrawnLastAndOneWhereItIsDrawnFirst) {
  Plates plates;
  plates.add(0, 16000, 0);
  plates.add(0, 8000, 1000);
  EXPECT_NEAR(plates.overdraw({0, 1}), 1.5, 1.0 / kWidth);
  EXPECT_EQ(plates.overdraw({1, 0}), 1.0);
}

TEST(Overdraw, CountsThePixelsAloneThatShowSomething) {
  Plates plates;
  plates.add(0, 8000, 0);
  plates.add(0, 8000, 500);
  plates.add(0, 8000, 1000);
  EXPECT_EQ(plates.overdraw({0}), 1.0);
  EXPECT_NEAR(plates.overdraw({0, 1, 2}), 3.0, 3.0 / kWidth);
  EXPECT_EQ(plates.overdraw({}), 0.0);
}

}  // namespace
}  // namespace cornice::viewer
