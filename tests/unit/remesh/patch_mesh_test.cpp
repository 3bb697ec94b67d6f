// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/patch_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/base/random.h"
#include "tests/support/meshes.h"

namespace cornice::remesh {
namespace {

/// Every half-edge and its twin run along one edge in opposite directions; every vertex's ring
/// closes or starts at the rim.
void expect_sound(const PatchMesh& mesh) {
  for (std::uint32_t h = 0; h < mesh.half_edge_count(); ++h) {
    if (!mesh.alive(h) || mesh.twin(h) == kNone) continue;
    ASSERT_EQ(mesh.twin(mesh.twin(h)), h);
    ASSERT_EQ(mesh.start(mesh.twin(h)), mesh.end(h));
    ASSERT_EQ(mesh.end(mesh.twin(h)), mesh.start(h));
  }
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> corners(mesh.vertex_count(), 0);
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!mesh.triangle_alive(t)) continue;
    triangles.push_back({mesh.start(3 * t), mesh.start(3 * t + 1), mesh.start(3 * t + 2)});
    for (const std::uint32_t v : triangles.back()) ++corners[v];
  }
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    ASSERT_EQ(mesh.vertex_alive(v), corners[v] > 0);
    if (!mesh.vertex_alive(v)) continue;
    std::uint32_t ring = 0;
    mesh.each_out(v, [&](std::uint32_t h) {
      EXPECT_EQ(mesh.start(h), v);
      return ++ring <= corners[v];
    });
    ASSERT_EQ(ring, corners[v]);
  }
  EXPECT_TRUE(check_topology(triangles, mesh.vertex_count(), 1).is_manifold());
}

PatchMesh square(int cells) {
  Mesh mesh = test::height_mesh(0, 0, cells, 1.0, [](double, double) { return 0.0; });
  std::vector<std::uint8_t> fixed;
  for (const Vec3f p : mesh.positions) {
    const auto side = static_cast<float>(cells);
    fixed.push_back(p.x == 0 || p.y == 0 || p.x == side || p.y == side);
  }
  return {mesh.positions, mesh.triangles, fixed};
}

TEST(PatchMesh, StaysAManifoldUnderAnyOrderOfOperations) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PatchMesh mesh = square(6);
    expect_sound(mesh);
    for (std::uint64_t step = 0; step < 400; ++step) {
      CounterRandom random(seed, 1, step);
      const auto h = static_cast<std::uint32_t>(random.bits() % mesh.half_edge_count());
      if (!mesh.alive(h)) continue;
      switch (random.bits() % 4) {
        case 0:
          if (mesh.twin(h) != kNone) {
            mesh.split(h, (mesh.position(mesh.start(h)) + mesh.position(mesh.end(h))) * 0.5f);
          }
          break;
        case 1:
          mesh.insert(h / 3, (mesh.position(mesh.start(h)) + mesh.position(mesh.end(h)) +
                              mesh.position(mesh.opposite(h))) /
                                 3.0f);
          break;
        case 2:
          if (mesh.may_flip(h)) mesh.flip(h);
          break;
        default:
          if (mesh.may_collapse(h)) mesh.collapse(h);
      }
    }
    expect_sound(mesh);
  }
}

/// Vertex 0 is fixed and has two fans: one beside vertex 1, which is free and has a closed ring,
/// and a triangle of its own.
TEST(PatchMesh, KnowsTheNeighboursOfAVertexThatHasTwoFans) {
  std::vector<Triangle> triangles{{1, 0, 2}, {1, 2, 3}, {1, 3, 4}, {1, 4, 0}, {0, 5, 6}};
  const std::vector<Vec3f> positions{{0, 0, 0},  {1, 0, 0},  {1, 1, 0},  {2, 0, 0},
                                     {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}};
  for (int turn = 0; turn < 5; ++turn) {
    const PatchMesh mesh(positions, triangles, {1, 0, 1, 1, 1, 1, 1});
    EXPECT_TRUE(mesh.adjacent(0, 1));
    EXPECT_TRUE(mesh.adjacent(1, 0));
    EXPECT_FALSE(mesh.adjacent(5, 1));
    std::rotate(triangles.begin(), triangles.begin() + 1, triangles.end());
  }
}

TEST(PatchMesh, JoinsNoTwoFixedVerticesByANewEdge) {
  PatchMesh mesh = square(2);
  // Only the middle vertex is free: no flip of its edges may cut off a corner of the rim.
  for (std::uint32_t h = 0; h < mesh.half_edge_count(); ++h) {
    if (mesh.may_flip(h)) {
      EXPECT_FALSE(mesh.fixed(mesh.opposite(h)) && mesh.fixed(mesh.opposite(mesh.twin(h))));
    }
    EXPECT_FALSE(mesh.may_collapse(h));
  }
}

}  // namespace
}  // namespace cornice::remesh
