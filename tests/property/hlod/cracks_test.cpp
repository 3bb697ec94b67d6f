// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "bench/cracks/checker.h"
#include "bench/cracks/random_views.h"
#include "core/base/random.h"
#include "core/mesh/surface_distance.h"
#include "tests/property/hlod/cluster_hierarchy.h"
#include "tests/support/hlod_cells.h"
#include "tests/support/meshes.h"

namespace cornice::hlod {
namespace {

using bench::CrackChecker;
using bench::Drawn;
using bench::Hierarchy;
using bench::random_eye;
using bench::random_radii;
using bench::random_residency;

struct Case {
  std::string name;
  Mesh mesh;
  test::ClusterOptions options;
};

/// Square ground 64 m wide, 0.9 m triangles; a ridge and a valley.
Mesh ground() {
  return test::height_mesh(0.0, 0.0, 80, 0.8, [](double x, double y) {
    return 20.0 + 7.0 * std::exp(-0.02 * (x - 40.0) * (x - 40.0)) + std::sin(0.3 * y);
  });
}

std::vector<Case> cases() {
  std::vector<Case> list;
  for (const Partition partition : {Partition::kQuadtree, Partition::kOctree}) {
    for (const double share : {0.13, 0.25, 0.45}) {
      test::ClusterOptions options;
      options.partition = partition;
      options.edge_share = share;
      const std::string name = partition == Partition::kOctree ? "octree" : "quadtree";
      list.push_back({name + " ground " + std::to_string(share), ground(), options});
      options.root_side_m = 48.0;
      options.finest_level = 2;
      list.push_back({name + " overhang " + std::to_string(share),
                      test::overhang_mesh(60, 40, 6, 0.5), options});
      Mesh ball = test::sphere_mesh(30.0, 5);
      ball.origin = {1000.0, 2000.0, 300.0};
      list.push_back({name + " ball " + std::to_string(share), ball, options});
    }
  }
  return list;
}

std::string text(const Drawn& d) {
  return std::to_string(d.cells) + " cells, " + std::to_string(d.triangles) + " triangles";
}

TEST(Cracks, NoneForRandomEyesAndAnyRadiiThatObeyTheRule) {
  for (const Case& c : cases()) {
    const Hierarchy hierarchy = test::cluster_hierarchy(c.mesh, c.options);
    CrackChecker checker(hierarchy);
    ASSERT_LE(checker.parent_share(), 1.0) << c.name;
    ASSERT_LE(checker.edge_share(), 1.0) << c.name;
    std::uint64_t mixed = 0;
    for (std::uint64_t i = 0; i < 60; ++i) {
      CounterRandom random(1, 5, i);
      const FinePoint eye = random_eye(checker.tree(), random);
      const Radii radii = random_radii(checker.tree().metric, random);
      ASSERT_TRUE(obeys_rule(radii, checker.tree().metric));
      const Drawn drawn = checker.check(eye, radii);
      ASSERT_EQ(drawn.open_edges, 0u) << c.name << " eye " << i << ": " << text(drawn);
      ASSERT_EQ(drawn.level_jumps, 0u) << c.name << " eye " << i << ": " << text(drawn);
      mixed += drawn.degenerate > 0 ? 1 : 0;
    }
    EXPECT_GT(mixed, 5u) << c.name << ": hardly anything was morphed";
  }
}

// Of a strip of triangles just beyond a plane between cells nothing is left at the next level, but
// its cell is drawn there all the same: the border that it had is that of its neighbours now.
TEST(Cracks, NoneWhereCellsAtTheRimBecomeEmpty) {
  std::uint64_t empty = 0;
  for (const Partition partition : {Partition::kQuadtree, Partition::kOctree}) {
    for (int cells = 78; cells < 94; ++cells) {
      test::ClusterOptions options;
      options.partition = partition;
      const Mesh mesh = test::height_mesh(0.0, 0.0, cells, 0.8, [](double x, double y) {
        return 20.0 + 3.0 * std::sin(0.2 * x) + std::sin(0.3 * y);
      });
      const Hierarchy hierarchy = test::cluster_hierarchy(mesh, options);
      CrackChecker checker(hierarchy);
      for (const TreeCell& cell : checker.tree().cells) empty += cell.parts == 0;
      for (std::uint64_t i = 0; i < 20; ++i) {
        CounterRandom random(4, 5, i);
        const FinePoint eye = random_eye(checker.tree(), random);
        const Drawn drawn = checker.check(eye, random_radii(checker.tree().metric, random));
        ASSERT_EQ(drawn.open_edges + drawn.level_jumps, 0u) << cells << " cells, eye " << i;
      }
    }
  }
  EXPECT_GT(empty, 0u);
}

TEST(Cracks, NoneWhileAnythingIsMissing) {
  for (const Case& c : cases()) {
    const Hierarchy hierarchy = test::cluster_hierarchy(c.mesh, c.options);
    CrackChecker checker(hierarchy);
    const Tree& tree = checker.tree();
    Selection selection;
    for (std::uint64_t i = 0; i < 30; ++i) {
      CounterRandom random(2, 5, i);
      const FinePoint eye = random_eye(tree, random);
      Radii radii = random_radii(tree.metric, random);
      const std::vector<std::uint8_t> is_loaded = random_residency(tree, random);
      hold_to_loaded(tree, is_loaded, eye, {}, radii);
      ASSERT_TRUE(obeys_rule(radii, tree.metric));
      select(tree, radii, eye, {}, selection);
      for (const std::uint32_t cell : selection.cells) ASSERT_EQ(is_loaded[cell], 1);
      const Drawn drawn = checker.check(eye, radii);
      ASSERT_EQ(drawn.open_edges + drawn.level_jumps, 0u) << c.name << " eye " << i;
    }
  }
}

// The rule is needed: with radii that are nearer to each other there are cracks, and the checker
// sees them.
TEST(Cracks, AreFoundWhereTheRuleIsBroken) {
  const Case c = cases()[1];
  const Hierarchy hierarchy = test::cluster_hierarchy(cases()[0].mesh, c.options);
  CrackChecker checker(hierarchy);
  const Metric& metric = checker.tree().metric;
  std::uint64_t open = 0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    CounterRandom random(3, 5, i);
    Radii radii;
    for (int l = 0; l < metric.finest_level; ++l) {
      radii.of[static_cast<std::size_t>(l)] =
          metric.side(1) / 2 + (metric.finest_level - l) * (2 * metric.share(1) + 64);
    }
    radii.of[static_cast<std::size_t>(metric.finest_level)] = -metric.side(1) * 4;
    ASSERT_FALSE(obeys_rule(radii, metric));
    open += checker.check(random_eye(checker.tree(), random), radii).open_edges;
  }
  EXPECT_GT(open, 0u);
}

TEST(Cracks, NoneAlongAPathAndNoVertexJumps) {
  for (const std::size_t which : {std::size_t{0}, std::size_t{4}, std::size_t{10}}) {
    const Case c = cases()[which];
    const Hierarchy hierarchy = test::cluster_hierarchy(c.mesh, c.options);
    CrackChecker checker(hierarchy);
    const Tree& tree = checker.tree();
    const std::int32_t root = tree.metric.side(0);
    const std::int32_t step = root / 4096;
    std::vector<FinePoint> before;
    std::int32_t largest = 0;
    for (std::int32_t i = 0; i < 1500; ++i) {
      const double t = i / 1500.0;
      const FinePoint eye{-root / 8 + i * step,
                          static_cast<std::int32_t>(root * (0.5 + 0.1 * std::sin(3.0 * t))),
                          static_cast<std::int32_t>(root * 0.4)};
      const Radii radii = radii_for_eye(tree, 12.0, eye);
      const Drawn drawn = checker.check(eye, radii);
      ASSERT_EQ(drawn.open_edges + drawn.level_jumps, 0u) << c.name << " " << i;
      std::vector<FinePoint> now = checker.finest_vertices();
      for (FinePoint& p : now) p += eye;
      for (std::size_t v = 0; i > 0 && v < now.size(); ++v) {
        const FinePoint way = now[v] - before[v];
        largest = std::max({largest, std::abs(way.x), std::abs(way.y), std::abs(way.z)});
      }
      before = std::move(now);
    }
    // A vertex goes at most s0/2 of a cell side while the distance changes by the band, which is a
    // sixteenth of the side at least; the eye moves by up to `step` and radii twice as fast.
    EXPECT_GT(largest, 0);
    EXPECT_LE(largest, 3.0 * 8.0 * tree.metric.edge_share * step + 4.0) << c.name;
  }
}

TEST(Cracks, WhatIsDrawnStaysWithinTheErrorsOfItsCells) {
  for (const std::size_t which : {std::size_t{0}, std::size_t{1}, std::size_t{12}}) {
    const Case c = cases()[which];
    const Hierarchy hierarchy = test::cluster_hierarchy(c.mesh, c.options);
    CrackChecker checker(hierarchy);
    const Tree& tree = checker.tree();
    const float step = static_cast<float>(tree.lattice.step(tree.metric.finest_level));
    const auto surface = [&](FinePoint eye) {
      Mesh mesh;
      for (const auto& corners : checker.triangles()) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const FinePoint p : corners) mesh.positions.push_back(step * (p + eye).cast<float>());
        mesh.triangles.push_back({first, first + 1, first + 2});
      }
      return mesh;
    };
    Radii finest;
    for (int l = 0; l < tree.metric.finest_level; ++l) {
      finest.of[static_cast<std::size_t>(l)] = std::int64_t{1} << (30 - l);
    }
    settle(finest, tree.metric);
    checker.check({0, 0, 0}, finest);
    const Mesh truth = surface({0, 0, 0});
    const TriangleTree truth_tree(truth.positions, truth.triangles, 1);
    for (std::uint64_t i = 0; i < 6; ++i) {
      CounterRandom random(4, 5, i);
      const FinePoint eye = random_eye(tree, random);
      const Radii radii = random_radii(tree.metric, random);
      checker.check(eye, radii);
      const Mesh drawn = surface(eye);
      if (drawn.triangles.empty()) continue;
      const TriangleTree drawn_tree(drawn.positions, drawn.triangles, 1);
      const float distance = measure_distance(drawn_tree, truth_tree, 0.5f, 1).hausdorff_m();
      ASSERT_LE(distance, checker.error_bound_m() + 4.0 * step) << c.name << " eye " << i;
    }
  }
}

}  // namespace
}  // namespace cornice::hlod
