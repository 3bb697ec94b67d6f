// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/select.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/random.h"
#include "tests/support/hlod_cells.h"

namespace cornice::hlod {
namespace {

/// All cells of a quadtree of `levels` levels, errors doubling from level to level; the ground is
/// flat, at height 0.
std::vector<Node> full_quadtree(const Header& header, float finest_error_m) {
  std::vector<Node> nodes;
  for (int level = 0; level <= header.lattice.finest_level; ++level) {
    const int side = 1 << level;
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        Node node;
        node.key = {level, i, j, 0};
        const std::int32_t steps = 1 << header.lattice.cell_bits;
        node.lowest = {i * steps, j * steps, 0};
        node.highest = {(i + 1) * steps, (j + 1) * steps, 0};
        node.error_m = std::ldexp(finest_error_m, header.lattice.finest_level - level);
        node.triangles = 1000, node.vertices = 510, node.bytes = 1;
        nodes.push_back(node);
      }
    }
  }
  return nodes;
}

Header sample_header(int finest_level) {
  Header header = test::sample_header();
  header.lattice.finest_level = finest_level;
  header.lattice.root_side = 64.0 * (1 << finest_level);
  return header;
}

FinePoint eye_at(const Tree& tree, double x, double y, double z) {
  const double root = tree.metric.side(0);
  return {static_cast<std::int32_t>(x * root), static_cast<std::int32_t>(y * root),
          static_cast<std::int32_t>(z * root)};
}

TEST(Tree, PutsChildrenSideBySide) {
  const Header header = sample_header(4);
  const Tree tree = make_tree(header, full_quadtree(header, 0.1f));
  EXPECT_EQ(tree.cells.size(), 341u);
  EXPECT_EQ(tree.level(4).size(), 256u);
  std::set<std::uint32_t> seen;
  for (const TreeCell& cell : tree.cells) {
    EXPECT_EQ(cell.children, cell.key.level == 4 ? 0 : 4);
    for (std::uint32_t n = 0; n < cell.children; ++n) {
      EXPECT_EQ(tree.cells[cell.first_child + n].key.parent(), cell.key);
      EXPECT_TRUE(seen.insert(cell.first_child + n).second);
    }
  }
  EXPECT_EQ(seen.size(), 340u);
}

TEST(Tree, KeepsTheWayToCellsWhoseAncestorsVanished) {
  const Header header = sample_header(3);
  std::vector<Node> nodes = full_quadtree(header, 0.1f);
  std::erase_if(nodes, [](const Node& n) { return n.key.level < 3 && n.key.level > 0; });
  const Tree tree = make_tree(header, nodes);
  EXPECT_EQ(tree.cells.size(), 85u);
  Selection selection;
  select(tree, radii_by_factor(tree.metric, 8.0), eye_at(tree, 0.5, 0.5, 0.0), {}, selection);
  EXPECT_GT(selection.cells.size(), 0u);
  for (const std::uint32_t c : selection.cells) EXPECT_GT(tree.cells[c].parts, 0);
}

TEST(Select, DrawsEveryPlaceOnceAndNoNeighboursTwoLevelsApart) {
  const Header header = sample_header(6);
  const Tree tree = make_tree(header, full_quadtree(header, 0.05f));
  Selection selection;
  for (std::uint64_t i = 0; i < 200; ++i) {
    CounterRandom random(1, 0, i);
    const FinePoint eye =
        eye_at(tree, random.uniform(-1, 2), random.uniform(-1, 2), random.uniform(0, 0.2));
    const Radii radii = radii_for_eye(tree, random.uniform(20, 2000), eye);
    ASSERT_TRUE(obeys_rule(radii, tree.metric));
    select(tree, radii, eye, {}, selection);
    std::vector<int> level_of(64 * 64, -1);
    for (const std::uint32_t c : selection.cells) {
      const CellKey key = tree.cells[c].key;
      const int width = 1 << (6 - key.level);
      for (int x = key.i * width; x < (key.i + 1) * width; ++x) {
        for (int y = key.j * width; y < (key.j + 1) * width; ++y) {
          ASSERT_EQ(level_of[static_cast<std::size_t>(64 * x + y)], -1);
          level_of[static_cast<std::size_t>(64 * x + y)] = key.level;
        }
      }
    }
    for (std::size_t at = 0; at < level_of.size(); ++at) {
      ASSERT_GE(level_of[at], 0);
      const int right = at % 64 != 63 ? level_of[at + 1] : level_of[at];
      const int above = at < 63 * 64 ? level_of[at + 64] : level_of[at];
      ASSERT_LE(std::max(std::abs(level_of[at] - right), std::abs(level_of[at] - above)), 1);
    }
  }
}

TEST(Select, KeepsEveryDrawnErrorBelowTheTarget) {
  const Header header = sample_header(6);
  const Tree tree = make_tree(header, full_quadtree(header, 0.05f));
  const double scale = error_scale(2.0, 1080.0, 45.0);
  Selection selection;
  for (std::uint64_t i = 0; i < 200; ++i) {
    CounterRandom random(2, 0, i);
    const FinePoint eye =
        eye_at(tree, random.uniform(-1, 2), random.uniform(-1, 2), random.uniform(0, 0.2));
    select(tree, radii_for_eye(tree, scale, eye), eye, {}, selection);
    for (const std::uint32_t c : selection.cells) {
      const TreeCell& cell = tree.cells[c];
      if (cell.children == 0) continue;
      const double metres = cell_distance(tree, cell, eye) * tree.lattice.step(6);
      ASSERT_LE(cell.error_m * scale, metres + 0.01) << cell.key.level;
    }
  }
}

TEST(Select, DrawsOneRootWhereNothingHasErrors) {
  const Header header = sample_header(5);
  const Tree tree = make_tree(header, full_quadtree(header, 0.0f));
  const FinePoint eye = eye_at(tree, 0.4, 0.4, 0.0);
  Selection selection;
  select(tree, radii_for_eye(tree, 1000.0, eye), eye, {}, selection);
  EXPECT_EQ(selection.cells.size(), 1u);
}

TEST(Select, LeavesOutWhatTheFrustumDoesNotMeet) {
  const Header header = sample_header(6);
  const Tree tree = make_tree(header, full_quadtree(header, 0.05f));
  const FinePoint eye = eye_at(tree, 0.5, 0.5, 0.01);
  const Radii radii = radii_by_factor(tree.metric, 3.0);
  const Frustum frustum = make_frustum({1, 0, 0}, {0, 0, 1}, 60.0, 40.0);
  Selection all, seen;
  select(tree, radii, eye, {}, all);
  select(tree, radii, eye, frustum, seen);
  EXPECT_LT(seen.cells.size(), all.cells.size() / 2);
  const std::set<std::uint32_t> chosen(seen.cells.begin(), seen.cells.end());
  for (const std::uint32_t c : all.cells) {
    const TreeCell& cell = tree.cells[c];
    bool is_visible = false;
    for (int n = 0; n <= 20; ++n) {
      for (int m = 0; m <= 20; ++m) {
        const double x =
            cell.lowest.x + (double{1} * cell.highest.x - cell.lowest.x) * n / 20 - eye.x;
        const double y =
            cell.lowest.y + (double{1} * cell.highest.y - cell.lowest.y) * m / 20 - eye.y;
        const double z = -eye.z;
        is_visible = is_visible || (x > 0 && std::abs(y) < x * std::tan(0.5235987) &&
                                    std::abs(z) < x * std::tan(0.3490658));
      }
    }
    EXPECT_TRUE(!is_visible || chosen.contains(c));
  }
}

TEST(Radii, MoveAtMostTwiceAsFastAsTheEye) {
  const Header header = sample_header(6);
  std::vector<Node> nodes = full_quadtree(header, 0.002f);
  // One rough place, so that demands begin and end.
  for (Node& n : nodes) {
    const bool holds = n.key.i == (37 >> (6 - n.key.level)) && n.key.j == (21 >> (6 - n.key.level));
    if (holds) n.error_m = 1.0f;
  }
  const Tree tree = make_tree(header, nodes);
  const double scale = 400.0;
  Radii before;
  std::int64_t fastest = 0;
  for (int i = 0; i < 4000; ++i) {
    const double t = i / 4000.0;
    const FinePoint eye = eye_at(tree, -1.0 + 3.0 * t, 0.33, 0.01);
    const Radii now = radii_for_eye(tree, scale, eye);
    for (int l = 0; i > 0 && l < 6; ++l) {
      const auto k = static_cast<std::size_t>(l);
      // Levels that are not drawn have no say.
      if (std::max(now.of[k], before.of[k]) <= 0) continue;
      fastest = std::max(fastest, std::abs(now.of[k] - before.of[k]));
    }
    before = now;
  }
  const auto step = static_cast<std::int64_t>(3.0 * tree.metric.side(0) / 4000.0) + 1;
  EXPECT_GT(fastest, 0);
  EXPECT_LE(fastest, 2 * step + 2);
}

/// What every cell with children asks for, each asked.
Radii radii_of_all(const Tree& tree, double scale, FinePoint eye) {
  const Metric& metric = tree.metric;
  std::vector<double> reach(tree.cells.size(), 0.0);
  Radii radii;
  for (std::size_t c = tree.cells.size(); c-- > 0;) {
    const TreeCell& cell = tree.cells[c];
    if (cell.children == 0) continue;
    const int below = cell.key.level + 1;
    if (cell.error_m > 0.0f)
      reach[c] = double{cell.error_m} * (scale / tree.lattice.step(metric.finest_level)) +
                 2.0 * metric.share(below);
    for (std::uint32_t n = cell.first_child; n < cell.first_child + cell.children; ++n)
      if (reach[n] > 0.0) reach[c] = std::max(reach[c], reach[n] + metric.gap(below));
    const auto beyond = [](std::int32_t x, std::int32_t low, std::int32_t high) {
      return std::max({0, low - x, x - high});
    };
    const double distance = std::max({beyond(eye.x, cell.lowest.x, cell.highest.x),
                                      beyond(eye.y, cell.lowest.y, cell.highest.y),
                                      beyond(eye.z, cell.lowest.z, cell.highest.z)});
    std::int64_t& radius = radii.of[static_cast<std::size_t>(cell.key.level)];
    radius = std::max(radius, static_cast<std::int64_t>(
                                  std::ceil(reach[c] - 2.0 * std::max(0.0, distance - reach[c]))));
  }
  settle(radii, metric);
  return radii;
}

TEST(Radii, AreThoseOfAllCellsThoughFewAreAsked) {
  const Header header = sample_header(6);
  for (std::uint64_t i = 0; i < 60; ++i) {
    CounterRandom random(7, 0, i);
    std::vector<Node> nodes = full_quadtree(header, 0.05f);
    for (Node& node : nodes)
      node.error_m = random.uniform() < 0.2
                         ? 0.0f
                         : node.error_m * static_cast<float>(std::exp2(random.uniform(-4, 2)));
    const Tree tree = make_tree(header, nodes);
    for (int eyes = 0; eyes < 5; ++eyes) {
      const FinePoint eye =
          eye_at(tree, random.uniform(-1, 2), random.uniform(-1, 2), random.uniform(0, 0.3));
      const double scale = std::exp2(random.uniform(2, 12));
      ASSERT_EQ(radii_for_eye(tree, scale, eye).of, radii_of_all(tree, scale, eye).of)
          << i << " " << eyes;
    }
  }
}

TEST(Radii, ObeyTheirRuleAfterEveryChange) {
  const Header header = sample_header(7);
  const Tree tree = make_tree(header, full_quadtree(header, 0.05f));
  const FinePoint eye = eye_at(tree, 0.3, 0.7, 0.05);
  const Radii a = radii_for_eye(tree, 900.0, eye);
  const Radii b = radii_by_factor(tree.metric, 1.0);
  for (int i = 0; i <= 16; ++i) {
    EXPECT_TRUE(obeys_rule(scaled(a, i / 16.0, tree.metric), tree.metric)) << i;
    EXPECT_TRUE(obeys_rule(blended(a, b, i / 16.0, tree.metric), tree.metric)) << i;
  }
  EXPECT_EQ(blended(a, b, 0.0, tree.metric).of, a.of);
  EXPECT_EQ(blended(a, b, 1.0, tree.metric).of, b.of);
  EXPECT_EQ(scaled(a, 1.0, tree.metric).of, a.of);
}

TEST(Radii, FadeALevelOutAroundARisingEyeBeforeItsLastCellGoes) {
  const Header header = sample_header(5);
  const Tree tree = make_tree(header, full_quadtree(header, 0.05f));
  const double scale = 700.0;
  const std::int32_t step = tree.metric.side(5) / 256;
  // The eye goes by one step and radii twice as fast while weights change over a sixteenth of a
  // side at least.
  const std::int32_t most = 32768 * 3 * 16 / 256 + 64;
  FinePoint eye = eye_at(tree, 0.4, 0.6, 0.0);
  Selection selection;
  int finest = 5, gone = 0;
  std::int32_t before = 32768;
  for (int i = 0; finest > 0; ++i, eye.z += step) {
    ASSERT_LT(i, 200'000) << "level " << finest << " never ends";
    const Radii radii = radii_for_eye(tree, scale, eye);
    select(tree, radii, eye, {}, selection);
    int level = 0;
    for (const std::uint32_t c : selection.cells) level = std::max(level, tree.cells[c].key.level);
    // Of the vertex below the eye, which is the one that is most itself.
    const std::int32_t weight = level > 0 ? morph_weight(slab_distance(eye, tree.metric),
                                                         morph_band(radii, level, tree.metric))
                                          : 32768;
    if (level < finest) {
      EXPECT_LE(before, most) << "level " << finest << " went while it was to be seen";
      EXPECT_GE(weight, 32768 - most) << "level " << level << " came morphed";
      ++gone;
    } else {
      ASSERT_EQ(level, finest);
      ASSERT_LE(std::abs(weight - before), most) << "level " << level << " jumps at step " << i;
    }
    finest = level, before = weight;
  }
  EXPECT_EQ(gone, 5);
}

TEST(Budget, IsKept) {
  const Header header = sample_header(7);
  const Tree tree = make_tree(header, full_quadtree(header, 0.05f));
  const FinePoint eye = eye_at(tree, 0.3, 0.7, 0.01);
  const Radii radii = radii_for_eye(tree, 900.0, eye);
  Selection selection;
  select(tree, radii, eye, {}, selection);
  const std::uint64_t all = selection.triangles;
  for (const double part : {1.0, 0.6, 0.3, 0.1}) {
    const auto budget = static_cast<std::uint64_t>(part * static_cast<double>(all));
    const double share = share_for_budget(tree, radii, eye, {}, budget, selection);
    select(tree, scaled(radii, share, tree.metric), eye, {}, selection);
    EXPECT_LE(selection.triangles, budget);
    EXPECT_GT(selection.triangles, 0u);
    EXPECT_EQ(share == 1.0, part == 1.0);
  }
}

TEST(Loading, WantsCoarseBeforeFineAndNearBeforeFarAndEndsComplete) {
  const Header header = sample_header(5);
  const Tree tree = make_tree(header, full_quadtree(header, 0.05f));
  const FinePoint eye = eye_at(tree, 0.3, 0.7, 0.01);
  const Radii target = radii_for_eye(tree, 900.0, eye);
  std::vector<std::uint8_t> is_loaded(tree.cells.size(), 0);
  is_loaded[0] = 1;
  Selection selection, full;
  select(tree, target, eye, {}, full);
  std::uint64_t triangles = 0;
  for (int round = 0; round < 2000; ++round) {
    Radii radii = target;
    hold_to_loaded(tree, is_loaded, eye, {}, radii);
    select(tree, radii, eye, {}, selection);
    EXPECT_GE(selection.triangles, triangles) << "the picture got worse while loading";
    triangles = selection.triangles;
    const std::vector<std::uint32_t> wanted = wanted_cells(tree, is_loaded, target, eye, {});
    if (wanted.empty()) break;
    for (std::size_t n = 1; n < wanted.size(); ++n) {
      ASSERT_LE(tree.cells[wanted[n - 1]].key.level, tree.cells[wanted[n]].key.level);
    }
    is_loaded[wanted.front()] = 1;
  }
  EXPECT_EQ(selection.cells, full.cells);
}

}  // namespace
}  // namespace cornice::hlod
