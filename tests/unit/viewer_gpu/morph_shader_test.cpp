// SPDX-License-Identifier: GPL-3.0-or-later
// The vertex shader against hlod/morph.h, read back from the GPU.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/base/random.h"
#include "hlod/morph.h"
#include "hlod/select.h"
#include "terrain-viewer/render/gl.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "terrain-viewer/render/terrain_renderer.h"
#include "terrain-viewer/stream/packed_cell.h"
#include "tests/unit/viewer_gpu/put_whole.h"

namespace cornice::viewer {
namespace {

constexpr int kFinest = 9;
constexpr std::size_t kVertices = 4000;

/// One cell whose vertices lie anywhere in its box and have parents anywhere near.
struct Made {
  hlod::CellMesh mesh;
  hlod::Node node;
};

Made random_cell(int level, std::uint64_t seed) {
  CounterRandom random(seed, 5, static_cast<std::uint64_t>(level));
  const auto whole = [&](double low, double high) {
    return static_cast<std::int32_t>(std::floor(random.uniform(low, high)));
  };
  Made made;
  made.mesh.key = {level, whole(-4, 4), whole(-4, 4), 0};
  const std::int32_t x = made.mesh.key.i * 16384, y = made.mesh.key.j * 16384;
  for (std::size_t i = 0; i < kVertices; ++i) {
    hlod::CellVertex v;
    v.position = {x + whole(-4000, 20000), y + whole(-4000, 20000), whole(-30000, 60000)};
    made.mesh.vertices.push_back(v);
    hlod::CellVertex parent = v;
    const auto half = hlod::coarsened(v.position);
    parent.position = {half.x + whole(-1000, 1000), half.y + whole(-1000, 1000),
                       half.z + whole(-9000, 9000)};
    made.mesh.parents.push_back(parent);
    made.mesh.parent_of.push_back(static_cast<std::uint16_t>(i));
  }
  made.node = hlod::make_node(made.mesh, 0.0f, 0.0f);
  return made;
}

/// Places of all vertices as the shader computes them, relative to the eye, metres.
class ShaderPlaces {
 public:
  std::vector<Vec3f> of(const Made& made, const DrawList& list, Vec3d eye) {
    GpuCells cells(1 << 22);
    std::vector<CellId> dropped;
    const PackedCell packed = pack_cell(made.mesh, made.node, 0);
    cells.expect(packed.words.size() / kWordsPerVertex, packed.indices.size());
    EXPECT_TRUE(put_whole(cells, {0, 0}, packed, 1, dropped));
    DrawList with_cell = list;
    with_cell.items = {{0, *cells.use({0, 0}, 1)}};
    const GlBuffer places = make_buffer(kVertices * sizeof(Vec3f));
    Camera camera;
    camera.eye = eye;
    renderer_.begin(target_.framebuffer(), target_.width(), target_.height(), camera, {});
    renderer_.place(with_cell, cells, kVertices, places.id());
    std::vector<Vec3f> result(kVertices);
    glGetNamedBufferSubData(places.id(), 0, kVertices * sizeof(Vec3f), result.data());
    return result;
  }

 private:
  OffscreenContext context_;
  TerrainRenderer renderer_;
  Target target_{8, 8, 1};
};

TEST(MorphShader, PutsEveryVertexWhereTheReferencePutsIt) {
  ShaderPlaces places;
  hlod::Header header;
  header.lattice = {{2600000.0, 1200000.0, 300.0}, 32768.0, kFinest, 14};
  for (const auto partition : {hlod::Partition::kQuadtree, hlod::Partition::kOctree}) {
    header.partition = partition;
    hlod::Metric metric;
    metric.finest_level = kFinest;
    metric.partition = partition;
    metric.slab_high = 1 << 20;
    const hlod::Radii radii = hlod::radii_by_factor(metric, 2.5);
    for (const int level : {1, 4, kFinest - 1, kFinest}) {
      const Made made = random_cell(level, 11);
      const std::vector<hlod::Node> nodes{made.node};
      const double side = header.lattice.cell_side(level);
      std::size_t between = 0;
      for (int turn = 0; turn < 12; ++turn) {
        CounterRandom random(17, static_cast<std::uint64_t>(level), std::uint64_t(turn));
        const Vec3d eye =
            header.lattice.origin + Vec3d{(made.mesh.key.i + random.uniform(-6.0, 7.0)) * side,
                                          (made.mesh.key.j + random.uniform(-6.0, 7.0)) * side,
                                          random.uniform(-1.0, 3.0) * side};
        DrawList list;
        list.header = &header;
        list.nodes = &nodes;
        list.eye = hlod::fine_eye(eye, header.lattice);
        list.slab_distance = hlod::slab_distance(list.eye, metric);
        list.bands.assign(kFinest + 1, {});
        list.bands[std::size_t(level)] = hlod::morph_band(radii, level, metric);
        const auto seen = places.of(made, list, eye);
        const double step = header.lattice.step(kFinest);
        const Vec3d rest = eye - header.lattice.position(list.eye, kFinest);
        for (std::size_t i = 0; i < kVertices; ++i) {
          const hlod::LatticePoint own = made.mesh.vertices[i].position;
          const hlod::LatticePoint parent = made.mesh.parents[i].position;
          const hlod::MorphBand& band = list.bands[std::size_t(level)];
          const hlod::FinePoint p =
              hlod::morphed(own, parent, list.eye, list.slab_distance, partition, band);
          const auto weight =
              hlod::morph_weight(hlod::eye_distance(hlod::seen_from(list.eye, own, band.finer),
                                                    list.slab_distance, partition),
                                 band);
          between += weight > 0 && weight < 32768 ? 1 : 0;
          const auto metres = [&](std::int32_t steps, double off) {
            return static_cast<float>(steps) * static_cast<float>(step) + static_cast<float>(-off);
          };
          ASSERT_EQ(seen[i].x, metres(p.x, rest.x)) << "level " << level << " vertex " << i;
          ASSERT_EQ(seen[i].y, metres(p.y, rest.y));
          ASSERT_EQ(seen[i].z, metres(p.z, rest.z));
        }
      }
      EXPECT_GT(between, kVertices / 4) << "the band itself is not tried at level " << level;
    }
  }
}

}  // namespace
}  // namespace cornice::viewer
