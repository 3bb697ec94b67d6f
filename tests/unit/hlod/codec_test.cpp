// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "hlod/codec_bytes.h"
#include "hlod/codec_predict.h"
#include "hlod/file.h"
#include "hlod/octahedral.h"
#include "hlod/octahedral_lanes.h"
#include "tests/support/hlod_cells.h"
#include "tests/support/meshes.h"

namespace cornice::hlod {
namespace {

using test::bumpy_ground;
using test::same_mesh;
using test::sample_cell;
using test::sample_header;

constexpr CellKey kFine{3, 0, 0, 0};

CellMesh there_and_back(const CellMesh& mesh, const Header& header) {
  return decode_cell(encode_cell(mesh, header), make_node(mesh, 0, 0), header);
}

TEST(Octahedral, IsOffByLessThanWhatItPromises) {
  for (const auto& [bits, degrees] : {std::pair{8, 0.95}, std::pair{10, 0.24}}) {
    double worst = 0.0;
    for (std::uint64_t i = 0; i < 200'000; ++i) {
      CounterRandom random(1, 0, i);
      const Vec3f n =
          normalized(Vec3d{random.normal(), random.normal(), random.normal()}).cast<float>();
      const Vec3f back = decode_octahedral(encode_octahedral(n, bits), bits);
      worst = std::max(worst, std::atan2(norm(cross(n.cast<double>(), back.cast<double>())),
                                         dot(n.cast<double>(), back.cast<double>())));
    }
    EXPECT_LT(worst * 57.29578, degrees) << bits;
  }
}

TEST(Octahedral, KeepsTheAxes) {
  for (const Vec3f n : {Vec3f{1, 0, 0}, Vec3f{0, -1, 0}, Vec3f{0, 0, 1}, Vec3f{0, 0, -1}}) {
    EXPECT_EQ(decode_octahedral(encode_octahedral(n, 8), 8), n);
  }
}

TEST(Octahedral, IsTheSameOfManyAtOnceAndOfOne) {
  for (const int bits : {8, 10, 16}) {
    std::vector<Vec3f> normals{{}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {-3, 4, 0}};
    for (std::uint64_t i = 0; i < 10'003; ++i) {
      CounterRandom random(2, 0, i);
      normals.push_back(Vec3d{random.normal(), random.normal(), random.normal()}.cast<float>());
    }
    encode_octahedral(
        0, normals.size(), bits, [&](std::size_t v) { return normals[v]; },
        [&](std::size_t v, std::array<std::int16_t, 2> packed) {
          ASSERT_EQ(packed, encode_octahedral(normals[v], bits)) << v << " " << bits;
        });
  }
}

TEST(Octahedral, GivesAUnitVectorForEveryPair) {
  for (int x = -128; x < 128; ++x) {
    for (int y = -128; y < 128; ++y) {
      const Vec3f n =
          decode_octahedral({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)}, 8);
      ASSERT_NEAR(norm(n), 1.0f, 1e-5f) << x << " " << y;
    }
  }
}

TEST(CellCodec, GivesBackGroundWithAllAttributes) {
  Header header = sample_header();
  for (const int bits : {8, 10}) {
    header.normal_bits = bits;
    const CellMesh mesh = sample_cell(bumpy_ground(60, 50, 7), header, kFine, 7);
    EXPECT_TRUE(same_mesh(there_and_back(mesh, header), mesh)) << bits;
  }
}

TEST(CellCodec, EncodesWhatItDecodedToTheSameMeshAgain) {
  const Header header = sample_header();
  const CellMesh once =
      there_and_back(sample_cell(bumpy_ground(30, 30, 3), header, kFine, 3), header);
  EXPECT_TRUE(same_mesh(there_and_back(once, header), once));
}

TEST(CellCodec, KeepsNoParentsAtTheRoot) {
  const Header header = sample_header();
  const CellMesh mesh = sample_cell(bumpy_ground(20, 20, 5), header, {0, 0, 0, 0}, 5);
  const CellMesh back = there_and_back(mesh, header);
  EXPECT_TRUE(same_mesh(back, mesh));
  EXPECT_TRUE(back.parents.empty() && back.parent_of.empty());
}

TEST(CellCodec, GivesBackClosedSurfacesAndOverhangs) {
  const Header header = sample_header();
  for (Mesh mesh : {test::sphere_mesh(20.0, 4), test::overhang_mesh(40.0, 20.0, 4.0, 0.5)}) {
    mesh.normals.assign(mesh.positions.size(), Vec3f{0, 0, 1});
    const CellMesh cell = sample_cell(mesh, header, kFine, 11);
    EXPECT_TRUE(same_mesh(there_and_back(cell, header), cell));
  }
}

TEST(CellCodec, GivesBackTrianglesThatHangTogetherBadly) {
  const Header header = sample_header();
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    CounterRandom random(seed, 3, 0);
    const int count = 3 + static_cast<int>(random.uniform(0.0, 40.0));
    Mesh mesh;
    for (int v = 0; v < count; ++v) {
      mesh.positions.push_back(
          Vec3d{random.uniform(0, 60), random.uniform(0, 60), random.uniform(0, 60)}.cast<float>());
      mesh.normals.push_back({0, 0, random.uniform() < 0.5 ? 1.0f : -1.0f});
    }
    const auto corner = [&] { return static_cast<std::uint32_t>(random.uniform(0.0, count)); };
    for (int t = 0; t < 3 * count; ++t) mesh.triangles.push_back({corner(), corner(), corner()});
    const CellMesh cell = sample_cell(mesh, header, kFine, seed);
    ASSERT_TRUE(same_mesh(there_and_back(cell, header), cell)) << seed;
  }
}

TEST(CellCodec, GivesBackAHubOfManyTrianglesSomeOfThemTwice) {
  const Header header = sample_header();
  for (const int repeats : {0, 1, 7}) {
    Mesh mesh;
    const int count = 3000;
    for (int v = 0; v <= count; ++v) {
      const double angle = 2 * 3.14159265358979 * v / count, reach = v == count ? 0 : 30 + v % 7;
      mesh.positions.push_back(
          Vec3d{30 + reach * std::cos(angle), 30 + reach * std::sin(angle), 0.01 * v}
              .cast<float>());
      mesh.normals.push_back({0, 0, 1});
    }
    const auto corner = [](int v) { return static_cast<std::uint32_t>(v); };
    for (int v = 0; v < count; ++v) {
      mesh.triangles.push_back({corner(count), corner(v), corner((v + 1) % count)});
      if (repeats > 0 && v % 500 < repeats) mesh.triangles.push_back(mesh.triangles.back());
    }
    const CellMesh cell = sample_cell(mesh, header, kFine, 5);
    ASSERT_TRUE(same_mesh(there_and_back(cell, header), cell)) << repeats;
  }
}

TEST(CellCodec, GivesBackAnEmptyCellAndLoneVertices) {
  const Header header = sample_header();
  CellMesh empty;
  empty.key = kFine;
  EXPECT_TRUE(same_mesh(there_and_back(empty, header), empty));
  Mesh lone;
  lone.positions = {{1, 2, 3}, {4, 5, 6}};
  lone.normals = {{0, 0, 1}, {1, 0, 0}};
  const CellMesh cell = sample_cell(lone, header, kFine, 1);
  EXPECT_TRUE(same_mesh(there_and_back(cell, header), cell));
}

TEST(CellCodec, GivesBackPositionsAtTheEdgeOfTheLattice) {
  Header header = sample_header();
  header.attributes = 0;
  CellMesh cell;
  cell.key = kFine;
  const std::int32_t far = (1 << 29);
  for (const LatticePoint p : {LatticePoint{-far, far, 0}, LatticePoint{far, -far, far},
                               LatticePoint{far, far, -far}, LatticePoint{-far, -far, far}}) {
    CellVertex vertex;
    vertex.position = p;
    cell.vertices.push_back(vertex);
    vertex.position = coarsened(p);
    cell.parent_of.push_back(static_cast<std::uint16_t>(cell.parents.size()));
    cell.parents.push_back(vertex);
  }
  cell.triangles = {{0, 1, 2}, {2, 1, 3}, {0, 2, 3}, {0, 3, 1}};
  EXPECT_TRUE(same_mesh(there_and_back(cell, header), cell));
}

/// As docs/formats/hlod.md has it: whole numbers of 64 bits that wrap around.
std::vector<PackedNormal> guesses_in_whole_numbers(const std::vector<CellVertex>& vertices,
                                                   const std::vector<SmallTriangle>& triangles,
                                                   int bits) {
  std::vector<std::array<std::uint64_t, 3>> sums(vertices.size());
  for (const SmallTriangle& t : triangles) {
    const auto edge = [&](std::size_t corner) {
      const LatticePoint p = vertices[t[corner]].position, a = vertices[t[0]].position;
      return std::array{std::int64_t{p.x} - a.x, std::int64_t{p.y} - a.y, std::int64_t{p.z} - a.z};
    };
    const auto u = edge(1), v = edge(2);
    const auto times = [](std::int64_t p, std::int64_t q) {
      return static_cast<std::uint64_t>(p) * static_cast<std::uint64_t>(q);
    };
    for (const std::uint16_t corner : t) {
      sums[corner][0] += times(u[1], v[2]) - times(u[2], v[1]);
      sums[corner][1] += times(u[2], v[0]) - times(u[0], v[2]);
      sums[corner][2] += times(u[0], v[1]) - times(u[1], v[0]);
    }
  }
  std::vector<PackedNormal> guesses;
  for (const auto& sum : sums) {
    const auto number = [](std::uint64_t word) {
      return static_cast<double>(static_cast<std::int64_t>(word));
    };
    guesses.push_back(round_octahedral({number(sum[0]), number(sum[1]), number(sum[2])}, bits));
  }
  return guesses;
}

TEST(GuessedNormals, AreThoseOfWholeNumbersHoweverFarApartVerticesLie) {
  // Up to 2^17 apart sums fit into doubles; beyond 2^31 products of differences wrap around.
  const std::array<std::int32_t, 6> extents{50, 1 << 16, 1 << 17, (1 << 17) + 1, 1 << 24, 1 << 30};
  for (const std::int32_t extent : extents) {
    CounterRandom random(7, 0, static_cast<std::uint64_t>(extent));
    const auto coordinate = [&] {
      // Often at the ends, for the longest sums.
      const double share = random.uniform();
      if (share < 0.25) return -extent / 2;
      if (share > 0.75) return extent - extent / 2;
      return static_cast<std::int32_t>((2.0 * share - 1.0) * (extent / 2));
    };
    std::vector<CellVertex> vertices(300);
    for (CellVertex& v : vertices) {
      v.position = {coordinate(), coordinate(), coordinate()};
      v.normal = {static_cast<std::int16_t>(coordinate()), static_cast<std::int16_t>(coordinate())};
    }
    std::vector<SmallTriangle> triangles(40'000);
    // One vertex of all of them, and the largest triangle over and over.
    const auto any = [&] { return static_cast<std::uint16_t>(300.0 * random.uniform()); };
    for (SmallTriangle& t : triangles) t = {0, any(), any()};
    vertices[1].position = {-extent / 2, -extent / 2, -extent / 2};
    vertices[2].position = {extent - extent / 2, -extent / 2, -extent / 2};
    vertices[3].position = {-extent / 2, extent - extent / 2, extent - extent / 2};
    triangles.insert(triangles.end(), 200'000, {1, 2, 3});
    for (const int bits : {8, 10}) {
      EXPECT_EQ(guessed_normals(vertices, triangles, bits),
                guesses_in_whole_numbers(vertices, triangles, bits))
          << "extent " << extent;
    }
  }
}

TEST(CellCodec, GivesBackAsManyVerticesAsSixteenBitsIndex) {
  Header header = sample_header();
  header.attributes = 0;
  const CellMesh cell = sample_cell(bumpy_ground(257, 255, 2), header, kFine, 2);
  ASSERT_EQ(cell.vertices.size(), 65535u);
  EXPECT_TRUE(same_mesh(there_and_back(cell, header), cell));
}

TEST(CellCodec, RefusesCountsThatAreNotTheBlocks) {
  const Header header = sample_header();
  const CellMesh mesh = sample_cell(bumpy_ground(20, 20, 5), header, kFine, 5);
  const auto block = encode_cell(mesh, header);
  const Node good = make_node(mesh, 0, 0);
  for (std::uint32_t Node::*count : {&Node::triangles, &Node::vertices, &Node::parents}) {
    for (const int change : {-1, 1, 100'000'000}) {
      Node bad = good;
      bad.*count += static_cast<std::uint32_t>(change);
      EXPECT_THROW(decode_cell(block, bad, header), InputError);
    }
  }
}

TEST(CellCodec, RefusesPositionsOutsideOfTheNodesBox) {
  const Header header = sample_header();
  const CellMesh mesh = sample_cell(bumpy_ground(20, 20, 5), header, kFine, 5);
  Node node = make_node(mesh, 0, 0);
  --node.highest.z;
  EXPECT_THROW(decode_cell(encode_cell(mesh, header), node, header), InputError);
}

// Without the checksum, as a fuzzer calls it: whatever comes out is whole, or is refused.
TEST(CellCodec, SurvivesCutAndFlippedBytes) {
  const Header header = sample_header();
  const CellMesh mesh = sample_cell(bumpy_ground(12, 12, 9), header, kFine, 9);
  const Node node = make_node(mesh, 0, 0);
  const std::vector<std::byte> block = encode_cell(mesh, header);
  int refused = 0;
  const auto try_to_decode = [&](std::span<const std::byte> bytes) {
    try {
      const CellMesh back = decode_cell(bytes, node, header);
      for (const auto& t : back.triangles) {
        for (const std::uint16_t v : t) ASSERT_LT(v, back.vertices.size());
      }
      for (const std::uint16_t p : back.parent_of) ASSERT_LT(p, back.parents.size());
    } catch (const InputError&) {
      ++refused;
    }
  };
  for (std::size_t size = 0; size < block.size(); ++size) {
    try_to_decode(std::span(block).first(size));
  }
  EXPECT_EQ(refused, static_cast<int>(block.size()));
  for (std::size_t i = 0; i < block.size(); ++i) {
    std::vector<std::byte> flipped = block;
    flipped[i] ^= static_cast<std::byte>(1 + CounterRandom(4, 0, i).bits() % 255);
    try_to_decode(flipped);
  }
  EXPECT_GT(refused, static_cast<int>(block.size()));
}

TEST(BlockNumbers, GoThereAndBackAndEndWithTheBlock) {
  BlockWriter writer;
  const std::vector<std::int32_t> values{0, 1, -1, 127, -128, 1 << 30, -(1 << 30), 2147483647};
  for (const std::int32_t value : values) writer.signed_number(value);
  const std::vector<std::byte> block = writer.take();
  BlockReader reader(block);
  for (const std::int32_t value : values) EXPECT_EQ(reader.signed_number(), value);
  EXPECT_TRUE(reader.ok() && reader.at_end());
  reader.number();
  EXPECT_FALSE(reader.ok());
}

}  // namespace
}  // namespace cornice::hlod
