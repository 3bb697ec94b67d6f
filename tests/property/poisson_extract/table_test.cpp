// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <set>

#include "stages/poisson/extract_polygon.h"
#include "stages/poisson/extract_table.h"

namespace cornice {
namespace {

/// Nodes at the ends of an edge.
std::array<unsigned, 2> ends(unsigned edge) {
  const unsigned low = edge & 1, high = edge >> 1 & 1;
  if (edge < 4) return {2 * low + 4 * high, 2 * low + 4 * high + 1};
  if (edge < 8) return {low + 4 * high, low + 4 * high + 2};
  return {low + 2 * high, low + 2 * high + 4};
}

TEST(ExtractTable, EveryCrossedEdgeIsInOneLoopOnceAndNoOther) {
  for (unsigned negative = 0; negative < 256; ++negative) {
    for (unsigned joined = 0; joined < 64; ++joined) {
      const CellLoops& cell = cell_loops(negative, joined);
      std::multiset<unsigned> in_loops;
      unsigned used = 0;
      for (unsigned l = 0; l < cell.loops; ++l) {
        EXPECT_GE(cell.length[l], 3);
        for (unsigned e = 0; e < cell.length[l]; ++e) in_loops.insert(cell.edges[used++]);
      }
      for (unsigned e = 0; e < 12; ++e) {
        const auto [a, b] = ends(e);
        const bool crossed = (negative >> a & 1) != (negative >> b & 1);
        EXPECT_EQ(in_loops.count(e), crossed ? 1u : 0u) << negative << " " << joined;
      }
    }
  }
}

/// Surface edges of a cell on one face, as pairs of the face's own nodes, so that both cells of a
/// face can be compared: x faces by (y, z), and so on.
std::set<std::array<unsigned, 4>> edges_on_face(const CellLoops& cell, unsigned face) {
  const unsigned axis = face / 2;
  const auto flat = [&](unsigned node) { return node & ~(1u << axis); };
  std::set<std::array<unsigned, 4>> found;
  const std::uint8_t* edges = cell.edges.data();
  for (unsigned l = 0; l < cell.loops; edges += cell.length[l], ++l) {
    for (unsigned e = 0; e < cell.length[l]; ++e) {
      const unsigned a = edges[e], b = edges[(e + 1) % cell.length[l]];
      if ((kEdgeFaces[a] & kEdgeFaces[b] & 1u << face) == 0) continue;
      found.insert({flat(ends(a)[0]), flat(ends(a)[1]), flat(ends(b)[0]), flat(ends(b)[1])});
    }
  }
  return found;
}

TEST(ExtractTable, BothCellsOfAFaceDrawTheSameEdgesOnItInOppositeDirections) {
  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned bit = 1u << axis;
    for (unsigned first = 0; first < 256; ++first) {
      for (unsigned second = 0; second < 256; ++second) {
        bool same_face = true;
        for (unsigned node = 0; node < 8; ++node) {
          if ((node & bit) == 0) {
            same_face = same_face && (second >> node & 1) == (first >> (node | bit) & 1);
          }
        }
        if (!same_face) continue;
        for (const unsigned joined : {0u, 63u}) {
          const auto low = edges_on_face(cell_loops(first, joined), 2 * axis + 1);
          const auto high = edges_on_face(cell_loops(second, joined), 2 * axis);
          std::set<std::array<unsigned, 4>> turned;
          for (const auto& e : high) turned.insert({e[2], e[3], e[0], e[1]});
          EXPECT_EQ(low, turned) << first << " " << second << " " << axis;
        }
      }
    }
  }
}

TEST(ExtractTable, ALoopAroundANegativeCornerLooksAwayFromIt) {
  const CellLoops& cell = cell_loops(1, 0);
  ASSERT_EQ(cell.loops, 1);
  ASSERT_EQ(cell.length[0], 3);
  // Counter-clockwise seen from (1, 1, 1): x, y, z.
  EXPECT_EQ(cell.edges[0], 0);
  EXPECT_EQ(cell.edges[1], 4);
  EXPECT_EQ(cell.edges[2], 8);
}

TEST(ExtractTable, OnlyFacesWithAlternatingSignsAreAmbiguous) {
  EXPECT_EQ(ambiguous_faces(0b00000001), 0);
  EXPECT_EQ(ambiguous_faces(0b00001001), 1u << 4);  // nodes 0 and 3: face z = 0
  EXPECT_EQ(ambiguous_faces(0b01101001), 0b111111u);
}

TEST(CutLoop, TakesTheShorterDiagonalOfAQuadrangle) {
  std::array<LoopCorner, 4> loop{
      {{0, 0, {0, 0, 0}}, {1, 0, {10, 0, 0}}, {2, 0, {12, 10, 0}}, {3, 0, {0, 10, 0}}}};
  LoopTriangles triangles;
  ASSERT_EQ(cut_loop(loop, triangles), 2u);
  EXPECT_EQ(triangles[0], (std::array<std::uint8_t, 3>{0, 1, 3}));
  EXPECT_EQ(triangles[1], (std::array<std::uint8_t, 3>{1, 2, 3}));
}

TEST(CutLoop, DrawsNoDiagonalOnAFace) {
  std::array<LoopCorner, 4> loop{
      {{0, 1, {0, 0, 0}}, {1, 2, {10, 0, 0}}, {2, 1, {1, 1, 0}}, {3, 4, {0, 10, 0}}}};
  LoopTriangles triangles;
  ASSERT_EQ(cut_loop(loop, triangles), 2u);
  EXPECT_EQ(triangles[0], (std::array<std::uint8_t, 3>{0, 1, 3}));
  loop[3].faces = 2;
  EXPECT_EQ(cut_loop(loop, triangles), 0u);
}

TEST(CutLoop, CutsLongLoopsIntoAllTheirTriangles) {
  for (std::size_t n = 5; n <= kMaxLoop; ++n) {
    std::array<LoopCorner, kMaxLoop> corners;
    const std::span<LoopCorner> loop(corners.data(), n);
    for (std::size_t c = 0; c < n; ++c) {
      loop[c].at = {static_cast<std::int32_t>(100 * c), static_cast<std::int32_t>(c * c), 7};
    }
    LoopTriangles triangles;
    ASSERT_EQ(cut_loop(loop, triangles), n - 2);
    std::map<std::pair<int, int>, int> sides;
    for (std::size_t t = 0; t < n - 2; ++t) {
      for (int e = 0; e < 3; ++e) {
        ++sides[{triangles[t][static_cast<std::size_t>(e)],
                 triangles[t][static_cast<std::size_t>((e + 1) % 3)]}];
      }
    }
    for (const auto& [side, count] : sides) EXPECT_EQ(count, 1);
    for (std::size_t c = 0; c < n; ++c) {
      EXPECT_EQ((sides.count({static_cast<int>(c), static_cast<int>((c + 1) % n)})), 1u);
    }
  }
}

}  // namespace
}  // namespace cornice
