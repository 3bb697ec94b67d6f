// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify_links.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "core/base/random.h"
#include "tests/support/meshes.h"

namespace cornice::hlod {
namespace {

std::set<std::uint32_t> neighbours(const std::vector<Triangle>& triangles, std::uint32_t vertex) {
  std::set<std::uint32_t> found;
  for (const Triangle& t : triangles) {
    if (std::count(t.begin(), t.end(), vertex) != 0) found.insert(t.begin(), t.end());
  }
  found.erase(vertex);
  return found;
}

/// Every link says of its vertex what the triangles do; of those that are gone nothing is asked.
void expect_same(const VertexLinks& links, const std::vector<Triangle>& triangles,
                 const std::vector<bool>& is_gone) {
  const auto vertex_count = static_cast<std::uint32_t>(is_gone.size());
  std::vector<std::size_t> counts(vertex_count, 0);
  for (const Triangle& t : triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      ++counts[t[c]];
      ASSERT_TRUE(links.has_triangle(t[c], t[(c + 1) % 3], t[(c + 2) % 3])) << "vertex " << t[c];
    }
  }
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (is_gone[v]) continue;
    ASSERT_EQ(links.triangle_count(v), counts[v]) << "vertex " << v;
    const std::set<std::uint32_t> near = neighbours(triangles, v);
    const std::vector<std::uint32_t> list(near.begin(), near.end());
    ASSERT_EQ(links.has_any(v, list), !list.empty()) << "vertex " << v;
    const Link& link = links.of(v);
    if (!link.is_loose()) {
      ASSERT_EQ(std::set<std::uint32_t>(link.at, link.at + link.count()), near) << "vertex " << v;
      for (std::uint32_t i = link.count(); i < Link::kMost; ++i) {
        ASSERT_EQ(link.at[i], Link::kEmpty) << "vertex " << v;
      }
    }
  }
}

/// One collapse of u, whose link is in order, into its place-th neighbour; false where the surface
/// would not stay one.
bool collapse(VertexLinks& links, std::vector<Triangle>& triangles, std::uint32_t u,
              std::uint32_t place) {
  const Link link = links.of(u);
  const std::uint32_t count = link.count(), target = link.at[place];
  std::array<std::uint32_t, 64> ring{};
  for (std::uint32_t i = 0; i < 2 * count; ++i) ring[i] = link.at[i % count];
  std::uint32_t begin = place + 2, end = place + count - 1;
  std::uint32_t before = ring[place + 1], after = ring[place + count - 1];
  if (!link.is_closed()) {
    begin = place == 0 ? 2 : 0;
    end = place == 0 ? count : count - 2;
    before = place == 0 ? ring[1] : Link::kEmpty;
    after = place == 0 ? Link::kEmpty : ring[place - 1];
  }
  const std::span<const std::uint32_t> others(&ring[begin], end - begin);
  const std::set<std::uint32_t> near = neighbours(triangles, target);
  if (std::any_of(others.begin(), others.end(), [&](std::uint32_t v) { return near.contains(v); }))
    return false;
  if (link.is_closed() && links.has_triangle(target, before, after) && count == 3) return false;
  if (link.is_closed() && links.triangle_count(target) == 3) return false;
  if (links.triangle_count(u) == 1 && links.triangle_count(target) == 1) return false;
  for (const std::uint32_t side : {before, after}) {
    if (side != Link::kEmpty && links.triangle_count(side) < 2) return false;
  }
  for (const std::uint32_t v : others) links.rename(v, u, target);
  if (before != Link::kEmpty) links.erase(before, u, target);
  if (after != Link::kEmpty) links.erase(after, u, target);
  links.merge(target, u, others, before, after);
  for (Triangle& t : triangles) std::replace(t.begin(), t.end(), u, target);
  std::erase_if(triangles,
                [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  return true;
}

/// A grid, beside it a fan of forty triangles that shares a corner with the grid.
std::vector<Triangle> grid_and_fan(std::uint32_t& vertex_count) {
  const Mesh mesh = test::height_mesh(0, 0, 9, 1, [](double, double) { return 0.0; });
  std::vector<Triangle> triangles = mesh.triangles;
  const auto hub = static_cast<std::uint32_t>(mesh.positions.size());
  const auto rim = [&](std::uint32_t i) { return i % 40 == 0 ? 0 : hub + i % 40; };
  for (std::uint32_t i = 0; i < 40; ++i) triangles.push_back({hub, rim(i), rim(i + 1)});
  vertex_count = hub + 40;
  return triangles;
}

TEST(VertexLinks, SayWhatTheTrianglesDoAfterAnyCollapses) {
  std::size_t collapses = 0, loosened = 0, tightened = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CounterRandom random(5, 1, seed);
    const auto below = [&](std::uint32_t n) {
      return static_cast<std::uint32_t>(random.uniform() * static_cast<double>(n));
    };
    std::uint32_t vertex_count = 0;
    std::vector<Triangle> triangles = grid_and_fan(vertex_count);
    VertexLinks links;
    links.assign(vertex_count, triangles);
    std::vector<bool> is_gone(vertex_count, false);
    ASSERT_NO_FATAL_FAILURE(expect_same(links, triangles, is_gone));
    // Half of the time into one vertex, which comes to have more neighbours than a link has room.
    const std::uint32_t greedy = below(100);
    for (int tries = 0; tries < 400; ++tries) {
      const std::uint32_t u = below(vertex_count);
      if (is_gone[u] || links.triangle_count(u) == 0) continue;
      if (links.of(u).is_loose()) {
        const bool done = links.tighten(u);
        tightened += done;
        if (!done) continue;
      }
      const Link& link = links.of(u);
      const auto found = std::find(link.at, link.at + link.count(), greedy);
      const bool is_near = found != link.at + link.count() && random.uniform() < 0.5;
      std::uint32_t place =
          is_near ? static_cast<std::uint32_t>(found - link.at) : below(link.count());
      if (!link.is_closed()) place = place == 0 ? 0 : link.count() - 1;
      const std::uint32_t target = link.at[place];
      const bool was_loose = links.of(target).is_loose();
      if (!collapse(links, triangles, u, place)) continue;
      ++collapses;
      is_gone[u] = true;
      loosened += !was_loose && links.of(target).is_loose();
      if (collapses % 8 == 0) {
        ASSERT_NO_FATAL_FAILURE(expect_same(links, triangles, is_gone)) << "seed " << seed;
      }
    }
    ASSERT_NO_FATAL_FAILURE(expect_same(links, triangles, is_gone)) << "seed " << seed;
  }
  EXPECT_GT(collapses, 2000u);
  EXPECT_GT(loosened, 10u);
  EXPECT_GT(tightened, 10u);
}

TEST(VertexLinks, TellFansFromWhatIsNoSurface) {
  const auto fan_of = [](const std::vector<Triangle>& triangles) {
    VertexLinks links;
    links.assign(24, triangles);
    return links.fan(0);
  };
  EXPECT_EQ(fan_of({}), Fan::kNone);
  EXPECT_EQ(fan_of({{0, 1, 2}}), Fan::kOpen);
  EXPECT_EQ(fan_of({{2, 0, 1}, {3, 0, 2}}), Fan::kOpen);
  EXPECT_EQ(fan_of({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}), Fan::kClosed);
  EXPECT_EQ(fan_of({{0, 1, 2}, {0, 2, 1}}), Fan::kNone);
  EXPECT_EQ(fan_of({{0, 1, 2}, {0, 3, 4}}), Fan::kNone);
  EXPECT_EQ(fan_of({{0, 1, 2}, {0, 1, 3}}), Fan::kNone);
  // Two circles through vertex 1, and one that comes back to where it was before.
  EXPECT_EQ(fan_of({{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 4}, {0, 4, 5}, {0, 5, 1}}), Fan::kNone);
  EXPECT_EQ(fan_of({{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 2}}), Fan::kNone);
  for (std::uint32_t count : {7u, 8u, 15u, 16u, 20u}) {
    std::vector<Triangle> open, closed;
    for (std::uint32_t i = 0; i < count; ++i) open.push_back({0, i + 1, i + 2});
    for (std::uint32_t i = 0; i < count; ++i) closed.push_back({0, i + 1, (i + 1) % count + 1});
    EXPECT_EQ(fan_of(open), Fan::kOpen) << count;
    EXPECT_EQ(fan_of(closed), Fan::kClosed) << count;
  }
}

TEST(VertexLinks, HoldAHubOfAnyNumberOfTriangles) {
  for (const std::uint32_t count : {31u, 255u, 256u, 511u, 512u, 513u, 800u, 1023u, 1024u, 3000u}) {
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
      triangles.push_back({0, i + 1, (i + 1) % count + 1});
    }
    VertexLinks links;
    links.assign(count + 1, triangles);
    ASSERT_NO_FATAL_FAILURE(expect_same(links, triangles, std::vector<bool>(count + 1, false)))
        << count;
  }
}

}  // namespace
}  // namespace cornice::hlod
