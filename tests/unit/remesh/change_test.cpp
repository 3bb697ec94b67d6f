// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/change.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/topology.h"
#include "tests/support/meshes.h"

namespace cornice::remesh {
namespace {

/// An input, and a patch of a result over it whose rim is fixed.
struct Ground {
  Ground(Mesh given, const Mesh& result)
      : input(std::move(given)),
        reference(input.positions, input.triangles,
                  match_half_edges(input.triangles, input.positions.size(), 1), 1),
        patch{PatchMesh(
                  result.positions, result.triangles,
                  border_vertices(result.triangles,
                                  match_half_edges(result.triangles, result.positions.size(), 1),
                                  result.positions.size())),
              std::vector<float>(result.positions.size(), 1.0f),
              std::vector<std::uint32_t>(result.positions.size(), 0),
              Guard(reference, {0.05f, 0.1f, 0.0f, 0.0f, true}),
              {}} {
    limits.guard = {0.05f, 0.1f, 0.0f, 0.0f, true};
    patch.guard.resize(result.triangles.size());
  }

  std::vector<Triangle> triangles() const {
    std::vector<Triangle> all;
    const PatchMesh& mesh = patch.mesh;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
      if (!mesh.triangle_alive(t)) continue;
      all.push_back({mesh.start(3 * t), mesh.end(3 * t), mesh.opposite(3 * t)});
    }
    return all;
  }

  Mesh input;
  Reference reference;
  RelaxPatch patch;
  RelaxLimits limits;
  std::vector<Vec3f> places;
};

Mesh flat(int cells, double step) {
  return test::height_mesh(0, 0, cells, step, [](double, double) { return 0.0; });
}

/// A triangle's corners, whichever is named first.
using Corners = std::array<float, 9>;
Corners corners_of(Vec3f a, Vec3f b, Vec3f c) {
  const auto as_array = [](Vec3f p, Vec3f q, Vec3f r) {
    return Corners{p.x, p.y, p.z, q.x, q.y, q.z, r.x, r.y, r.z};
  };
  return std::min({as_array(a, b, c), as_array(b, c, a), as_array(c, a, b)});
}
std::multiset<Corners> all_corners(const PatchMesh& mesh) {
  std::multiset<Corners> all;
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!mesh.triangle_alive(t)) continue;
    all.insert(corners_of(mesh.position(mesh.start(3 * t)), mesh.position(mesh.end(3 * t)),
                          mesh.position(mesh.opposite(3 * t))));
  }
  return all;
}

/// Any change, whether it makes sense or not, within the triangle or at the edge that it is at.
Change any_change(const PatchMesh& mesh, CounterRandom& random) {
  const auto h = static_cast<std::uint32_t>(random.bits() % mesh.half_edge_count());
  const auto kind = static_cast<Change::Kind>(random.bits() % 7);
  Change change{kind, h};
  if (!mesh.alive(h)) return {Change::Kind::kSplit, h};
  const Vec3f a = mesh.position(mesh.start(h)), b = mesh.position(mesh.end(h));
  const Vec3f c = mesh.position(mesh.opposite(h));
  change.to = (a + b) * 0.5f;
  if (kind == Change::Kind::kInsert) change.at = h / 3, change.to = (a + b + c) / 3.0f;
  if (kind == Change::Kind::kMove)
    change.at = mesh.start(h), change.to = a * 0.9f + change.to * 0.1f;
  return change;
}

TEST(Changer, MakesTheTrianglesItHasDescribedAndNoOthers) {
  std::array<int, 7> made{};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Mesh mesh = flat(6, 1.0);
    Ground ground(mesh, mesh);
    Changer changer(ground.patch, ground.reference, ground.limits, ground.places);
    for (std::uint64_t step = 0; step < 300; ++step) {
      CounterRandom random(seed, 2, step);
      const Change change = any_change(ground.patch.mesh, random);
      const std::uint32_t h = change.kind == Change::Kind::kInsert ? 3 * change.at : change.at;
      const bool exists = change.kind == Change::Kind::kMove ? ground.patch.mesh.vertex_alive(h)
                                                             : ground.patch.mesh.alive(h);
      if (!exists || !changer.may(change)) continue;
      changer.describe(change);
      if (!changer.fits()) continue;
      std::multiset<Corners> expected = all_corners(ground.patch.mesh);
      const PatchMesh& now = ground.patch.mesh;
      for (const std::uint32_t t : changer.taken()) {
        const auto gone =
            expected.find(corners_of(now.position(now.start(3 * t)), now.position(now.end(3 * t)),
                                     now.position(now.opposite(3 * t))));
        ASSERT_NE(gone, expected.end());
        expected.erase(gone);
      }
      for (const auto& [a, b, c] : changer.facets()) expected.insert(corners_of(a, b, c));
      changer.carry_out();
      ASSERT_EQ(all_corners(now), expected) << "kind " << static_cast<int>(change.kind);
      ASSERT_EQ(ground.patch.size.size(), now.vertex_count());
      ASSERT_EQ(ground.patch.hint.size(), now.vertex_count());
      ++made[static_cast<std::size_t>(change.kind)];
    }
    EXPECT_TRUE(
        check_topology(ground.triangles(), ground.patch.mesh.vertex_count(), 1).is_manifold());
  }
  for (const int count : made) EXPECT_GT(count, 20);
}

/// Ground with a groove of 0.4 m along y = 5, over which edges of 2.8 m run, and a result that lies
/// flat over it.
struct Groove : Ground {
  Groove()
      : Ground(test::height_mesh(
                   0, 0, 64, 0.125,
                   [](double, double y) { return -std::max(0.0, 0.4 - std::abs(y - 5.0)); }),
               flat(4, 2.0)) {
    limits.insists = true;
    limits.least_facing = -1.0f;
    // What hangs on the result keeps small changes from being made: all of the groove offends.
    for (std::uint32_t v = 0; v < input.positions.size(); ++v) {
      const Vec3f p = input.positions[v];
      for (std::uint32_t t = 0; t < patch.mesh.triangle_count(); ++t) {
        const NearestPoint near =
            nearest_on_triangle(p, patch.mesh.position(patch.mesh.start(3 * t)),
                                patch.mesh.position(patch.mesh.end(3 * t)),
                                patch.mesh.position(patch.mesh.opposite(3 * t)));
        if (near.distance_sq > p.z * p.z + 1e-6f) continue;
        patch.guard.add(t, v, near.distance_sq);
        break;
      }
    }
  }
  /// The triangle over the groove's middle as an offence that no single change mends.
  Offence offence() const {
    const Vec3f through{3.1f, 5.0f, -0.4f};
    const NearestPoint at = reference.tree().nearest(through, {});
    for (std::uint32_t t = 0; t < patch.mesh.triangle_count(); ++t) {
      const PatchMesh& mesh = patch.mesh;
      const NearestPoint near =
          nearest_on_triangle(through, mesh.position(mesh.start(3 * t)),
                              mesh.position(mesh.end(3 * t)), mesh.position(mesh.opposite(3 * t)));
      if (near.distance_sq < 0.17f) return {t, through, at.triangle, true, {}, 0.4f};
    }
    return {};
  }
  /// Heights of the vertices that mending adds.
  std::vector<float> heights_of_new() const {
    std::vector<float> heights;
    for (std::uint32_t v = 25; v < patch.mesh.vertex_count(); ++v) {
      heights.push_back(patch.mesh.position(v).z);
    }
    return heights;
  }
};

TEST(Mend, HalvesOntoTheInputBeforeAnythingElseWhereItInsists) {
  Groove groove;
  mend(groove.patch, groove.reference, groove.limits, {groove.offence()}, {});
  ASSERT_EQ(groove.heights_of_new().size(), 1u);
  const Vec3f at = groove.patch.mesh.position(25);
  // Half-way up a wall: not the place that the offence names, at the bottom.
  EXPECT_NEAR(at.z, -0.2f, 0.05f);
  EXPECT_LT(groove.reference.tree().nearest(at, {}).distance_sq, 1e-8f);
}

TEST(Mend, GoesThroughThePlaceWhereItDoesNotInsist) {
  Groove groove;
  groove.limits.insists = false;
  mend(groove.patch, groove.reference, groove.limits, {groove.offence()}, {});
  ASSERT_EQ(groove.heights_of_new().size(), 1u);
  EXPECT_NEAR(groove.heights_of_new()[0], -0.4f, 1e-6f);
}

/// A vertex amid six whose heights alternate, so that nothing but a move of it keeps the bound.
Mesh crown(Vec3f middle) {
  Mesh mesh;
  mesh.positions = {middle};
  for (std::uint32_t k = 0; k < 6; ++k) {
    const double angle = std::numbers::pi / 3.0 * k;
    mesh.positions.push_back(
        Vec3d{std::cos(angle), std::sin(angle), k % 2 == 0 ? 0.5 : -0.5}.cast<float>());
    mesh.triangles.push_back({0, k + 1, (k + 1) % 6 + 1});
  }
  return mesh;
}

TEST(Mend, MovesAVertexOntoThePlaceThatIsTooFar) {
  const Vec3f from{0.02f, 0.0f, 0.0f}, place{0.0f, 0.0f, 0.0f};
  Ground ground(crown(place), crown(from));
  mend(ground.patch, ground.reference, ground.limits, {{0, place, 0, true, {}, 0.051f}}, {});
  EXPECT_EQ(ground.patch.mesh.position(0), place);
  EXPECT_EQ(ground.patch.mesh.vertex_count(), 7u);
}

/// A hundredth of the bound: the place would be too far again in the next round, and in all after
/// it.
TEST(Mend, TakesNoMoveOfAHairsBreadthForARepair) {
  const Vec3f from{0.0005f, 0.0f, 0.0f}, place{0.0f, 0.0f, 0.0f};
  Ground ground(crown(place), crown(from));
  mend(ground.patch, ground.reference, ground.limits, {{0, place, 0, true, {}, 0.051f}}, {});
  EXPECT_EQ(ground.patch.mesh.position(0), from);
  EXPECT_EQ(ground.patch.mesh.vertex_count(), 8u);  // halved instead
}

/// Where the middle of six flat triangles comes to lie that begins at (x, 0, 0).
float smoothed(float x) {
  Mesh wheel = crown({x, 0.0f, 0.0f});
  for (Vec3f& p : wheel.positions) p.z = 0.0f;
  Mesh input = flat(40, 0.1);
  for (Vec3f& p : input.positions) p = p - Vec3f{2.0f, 2.0f, 0.0f};
  Ground ground(input, wheel);
  relax(ground.patch, ground.reference, ground.limits);
  EXPECT_EQ(ground.triangles().size(), 6u);
  return ground.patch.mesh.position(0).x;
}

TEST(Relax, MovesVerticesTowardsTheirMiddleButNotByLittle) {
  EXPECT_LT(smoothed(0.15f), 0.06f);
  EXPECT_EQ(smoothed(0.1f), 0.1f);
}

}  // namespace
}  // namespace cornice::remesh
