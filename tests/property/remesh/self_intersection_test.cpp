// SPDX-License-Identifier: GPL-3.0-or-later
// Remeshed ground does not run through itself, by CGAL's count.
// Its check at the start of the program stops under valgrind, which knows one way of rounding only.
#define CGAL_DISABLE_ROUNDING_MATH_CHECK
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "stages/remesh/remesh.h"
#include "tests/support/meshes.h"

namespace cornice::remesh {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

/// Pairs of triangles that meet elsewhere than along what they share.
std::size_t self_intersections(const Mesh& mesh) {
  Surface surface;
  for (const Vec3f p : mesh.positions) surface.add_vertex(Kernel::Point_3(p.x, p.y, p.z));
  for (const Triangle& t : mesh.triangles) {
    const auto face = surface.add_face(Surface::Vertex_index(t[0]), Surface::Vertex_index(t[1]),
                                       Surface::Vertex_index(t[2]));
    EXPECT_NE(face, Surface::null_face());
  }
  std::vector<std::pair<Surface::Face_index, Surface::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(pairs));
  return pairs.size();
}

/// Terraces with steep steps and 1 cm of noise, as a reconstruction of masonry or rock gives them.
Mesh terraces(int cells) {
  return test::height_mesh(0, 0, cells, 0.4, [](double x, double y) {
    const double along = x + 3.0 * std::sin(y / 7.0);
    const double step = std::floor(along / 6.0);
    const double within = along / 6.0 - step;
    const double noise = CounterRandom(11, static_cast<std::uint64_t>(std::lround(10 * x)),
                                       static_cast<std::uint64_t>(std::lround(10 * y)))
                             .normal();
    return 1.5 * (step + 0.5 * (1.0 + std::tanh((within - 0.5) * 20.0))) + 0.01 * noise;
  });
}

TEST(RemeshedGround, IsSeenToRunThroughItselfWhereItDoes) {
  Mesh mesh = test::height_mesh(0, 0, 10, 1.0, [](double, double) { return 0.0; });
  // One vertex sinks beside its place: its triangles cut through those of the next one.
  for (Vec3f& p : mesh.positions) {
    if (p.x == 4.0f && p.y == 5.0f) p = {6.6f, 5.2f, -0.5f};
    if (p.x == 5.0f && p.y == 5.0f) p.z = -1.0f;
  }
  EXPECT_GT(self_intersections(mesh), 0u);
}

TEST(RemeshedGround, DoesNotRunThroughItselfAtSteps) {
  const Mesh mesh = terraces(150);
  ASSERT_EQ(self_intersections(mesh), 0u);
  Options options;
  options.max_error_m = 0.1;
  const Result result = remesh(mesh, options);
  EXPECT_LE(result.figures.hausdorff_m(), options.max_error_m);
  EXPECT_GE(result.figures.quality.share_min_angle_20(), 0.99);
  EXPECT_EQ(self_intersections(result.mesh), 0u);
}

TEST(RemeshedGround, DoesNotRunThroughItselfAtAnOverhang) {
  const Mesh mesh = test::overhang_mesh(60, 40, 6, 0.4);
  ASSERT_EQ(self_intersections(mesh), 0u);
  const Result result = remesh(mesh, {});
  EXPECT_EQ(self_intersections(result.mesh), 0u);
}

}  // namespace
}  // namespace cornice::remesh
