// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/guard.h"

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace cornice::remesh {
namespace {

/// A flat square of 8 m with a vertex every metre, and a spike of `height` at (4, 4).
Mesh spiked_square(double height) {
  return test::height_mesh(0, 0, 8, 1.0,
                           [=](double x, double y) { return x == 4 && y == 4 ? height : 0.0; });
}

struct Square {
  explicit Square(double height, float error_m)
      : mesh(spiked_square(height)),
        reference(mesh.positions, mesh.triangles,
                  match_half_edges(mesh.triangles, mesh.positions.size(), 1), 1),
        guard(reference, {error_m, 0.5f}) {
    guard.resize(mesh.triangles.size());
  }
  std::uint32_t vertex(std::uint32_t x, std::uint32_t y) const { return y * 9 + x; }
  /// Describes the vertex at (x, y) going, its neighbours joined to the one on its right.
  void begin_removal(std::uint32_t x, std::uint32_t y) {
    const std::uint32_t v = vertex(x, y), to = vertex(x + 1, y);
    guard.begin();
    guard.take_vertex(v);
    fresh.clear();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      Triangle c = mesh.triangles[t];
      if (c[0] != v && c[1] != v && c[2] != v) continue;
      guard.take(t);
      while (c[0] != v) c = {c[1], c[2], c[0]};
      if (c[1] == to || c[2] == to) continue;
      guard.put(mesh.positions[to], mesh.positions[c[1]], mesh.positions[c[2]]);
      fresh.push_back(t);
    }
  }
  std::size_t carried() const {
    std::size_t count = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      guard.each(t, [&](std::uint32_t, float) { ++count; });
    }
    return count;
  }

  Mesh mesh;
  Reference reference;
  Guard guard;
  std::vector<std::uint32_t> fresh;
};

TEST(Guard, LetsAVertexGoThatItsNeighboursReplace) {
  Square square(0.03, 0.05f);
  square.begin_removal(4, 4);
  ASSERT_TRUE(square.guard.fits(square.reference.triangle_at(square.vertex(5, 4))));
  square.guard.commit(square.fresh);
  EXPECT_EQ(square.carried(), 1u);
  for (const std::uint32_t t : square.fresh) {
    square.guard.each(t, [&](std::uint32_t id, float distance_sq) {
      EXPECT_EQ(id, square.vertex(4, 4));
      EXPECT_NEAR(distance_sq, 0.03f * 0.03f, 1e-6f);
    });
  }
}

TEST(Guard, KeepsASpikeThatIsHigherThanTheBound) {
  Square square(0.2, 0.05f);
  square.begin_removal(4, 4);
  EXPECT_FALSE(square.guard.fits(square.reference.triangle_at(square.vertex(5, 4))));
}

TEST(Guard, RefusesANewSurfaceFarFromTheInputThoughAllVerticesAreNear) {
  Square square(0.0, 0.05f);
  square.begin_removal(4, 4);
  square.guard.put({4, 4, 0}, {4, 5, 3}, {3, 4, 3});
  EXPECT_FALSE(square.guard.fits(square.reference.triangle_at(square.vertex(5, 4))));
}

TEST(Guard, RefusesTrianglesWithoutArea) {
  Square square(0.0, 0.05f);
  square.begin_removal(4, 4);
  square.guard.put({4, 4, 0}, {5, 4, 0}, {6, 4, 0});
  EXPECT_FALSE(square.guard.fits(0));
  EXPECT_FALSE(square.guard.fits_anyway());
}

TEST(Guard, CarriesOnWhatATriangleCarried) {
  Square square(0.02, 0.05f);
  square.begin_removal(4, 4);
  ASSERT_TRUE(square.guard.fits(0));
  square.guard.commit(square.fresh);
  square.guard.renumber(square.fresh[0], 0);
  EXPECT_EQ(square.carried(), 1u);
}

TEST(Reference, FindsWhatIsNearFromAnywhere) {
  const Square square(0.0, 0.05f);
  for (const std::uint32_t from : {0u, 60u, 127u, Reference::kNoTriangle}) {
    std::uint32_t at = from;
    EXPECT_FALSE(square.reference.is_near({7.3f, 1.2f, 0.06f}, at, 0.0025f));
    EXPECT_EQ(at, from);
    EXPECT_TRUE(square.reference.is_near({7.3f, 1.2f, 0.04f}, at, 0.0025f));
    // From there on nothing has to be looked for.
    EXPECT_LE(square.reference.walk({7.3f, 1.2f, 0.04f}, at, 0.0f).distance_sq, 0.0017f);
    EXPECT_NEAR(square.reference.near({2.5f, 2.5f, 0.3f}, from, 0, 0).distance_sq, 0.09f, 1e-5f);
  }
}

}  // namespace
}  // namespace cornice::remesh
