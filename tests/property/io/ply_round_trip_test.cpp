// SPDX-License-Identifier: GPL-3.0-or-later
// What is written is read back to the last bit, for shapes of every kind, and damaged files never
// do more than end in an InputError.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/io/ply.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::read_text;
using test::TemporaryFolder;
using test::write_text;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed, 0, 0) {}
  std::uint64_t below(std::uint64_t n) { return random_.bits() % n; }
  bool coin() { return below(2) == 1; }
  Vec3f vector(double size) {
    const auto axis = [&] { return static_cast<float>(random_.uniform(-size, size)); };
    return {axis(), axis(), axis()};
  }
  float number() { return static_cast<float>(random_.normal()); }
  double wide() { return random_.uniform(-1e7, 1e7); }

 private:
  CounterRandom random_;
};

/// Sizes around the blocks that reader and writer work in, and empty.
std::size_t some_size(Draw& draw) {
  constexpr std::array<std::size_t, 9> kSizes{0, 1, 2, 1023, 1024, 1025, 8192, 8193, 20000};
  return kSizes[draw.below(kSizes.size())];
}

template <class Shape>
void fill_properties(Draw& draw, std::size_t n, Shape& shape) {
  const std::uint64_t floats = draw.below(4);
  for (std::uint64_t k = 0; k < floats; ++k) {
    std::vector<float> values(n);
    for (float& value : values) value = draw.number();
    shape.float_properties.push_back({"f" + std::to_string(k), std::move(values)});
  }
  const std::uint64_t bytes = draw.below(4);
  for (std::uint64_t k = 0; k < bytes; ++k) {
    std::vector<std::uint8_t> values(n);
    for (auto& value : values) value = static_cast<std::uint8_t>(draw.below(256));
    shape.byte_properties.push_back({"b" + std::to_string(k), std::move(values)});
  }
}

Mesh some_mesh(std::uint64_t seed) {
  Draw draw(seed);
  Mesh mesh;
  mesh.origin = {draw.wide(), draw.wide(), draw.wide()};
  mesh.crs_text = draw.coin() ? "EPSG:2056+5728" : "";
  const std::size_t n = some_size(draw);
  for (std::size_t i = 0; i < n; ++i) mesh.positions.push_back(draw.vector(1000.0));
  if (draw.coin()) {
    for (std::size_t i = 0; i < n; ++i) mesh.normals.push_back(normalized(draw.vector(1.0)));
  }
  fill_properties(draw, n, mesh);
  const std::size_t triangles = n == 0 ? 0 : some_size(draw);
  const auto corner = [&] { return static_cast<std::uint32_t>(draw.below(n)); };
  for (std::size_t i = 0; i < triangles; ++i) {
    mesh.triangles.push_back({corner(), corner(), corner()});
  }
  return mesh;
}

OrientedPoints some_points(std::uint64_t seed) {
  Draw draw(seed);
  OrientedPoints points;
  points.origin = {draw.wide(), draw.wide(), draw.wide()};
  const std::size_t n = some_size(draw);
  for (std::size_t i = 0; i < n; ++i) {
    points.positions.push_back(draw.vector(500.0));
    points.normals.push_back(normalized(draw.vector(1.0)));
  }
  if (draw.coin()) {
    for (std::size_t i = 0; i < n; ++i) points.quality.push_back(draw.number());
  }
  if (draw.coin()) {
    for (std::size_t i = 0; i < n; ++i) {
      points.line_id.push_back(static_cast<std::uint16_t>(draw.below(65536)));
    }
  }
  fill_properties(draw, n, points);
  return points;
}

template <class Shape>
void expect_same_vertices(const Shape& a, const Shape& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.crs_text, b.crs_text);
  EXPECT_TRUE(a.positions == b.positions);
  EXPECT_TRUE(a.normals == b.normals);
  ASSERT_EQ(a.float_properties.size(), b.float_properties.size());
  for (std::size_t k = 0; k < a.float_properties.size(); ++k) {
    EXPECT_EQ(a.float_properties[k].name, b.float_properties[k].name);
    EXPECT_TRUE(a.float_properties[k].values == b.float_properties[k].values);
  }
  ASSERT_EQ(a.byte_properties.size(), b.byte_properties.size());
  for (std::size_t k = 0; k < a.byte_properties.size(); ++k) {
    EXPECT_EQ(a.byte_properties[k].name, b.byte_properties[k].name);
    EXPECT_TRUE(a.byte_properties[k].values == b.byte_properties[k].values);
  }
}

TEST(PlyRoundTrip, KeepsMeshesToTheLastBit) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const Mesh mesh = some_mesh(seed);
    write_ply(folder / "a.ply", mesh);
    const Mesh read = read_ply_mesh(folder / "a.ply");
    expect_same_vertices(mesh, read);
    EXPECT_TRUE(mesh.triangles == read.triangles);
    const PlyInfo info = read_ply_info(folder / "a.ply");
    EXPECT_EQ(info.elements[0].count, mesh.positions.size());
    EXPECT_EQ(info.elements[1].count, mesh.triangles.size());
  }
}

TEST(PlyRoundTrip, KeepsOrientedPointsToTheLastBit) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const OrientedPoints points = some_points(seed);
    write_ply(folder / "a.ply", points);
    const OrientedPoints read = read_ply_points(folder / "a.ply");
    expect_same_vertices(points, read);
    EXPECT_TRUE(points.quality == read.quality);
    EXPECT_TRUE(points.line_id == read.line_id);
  }
}

TEST(PlyRoundTrip, GivesTheSameBytesAgain) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    write_ply(folder / "a.ply", some_mesh(seed));
    write_ply(folder / "b.ply", read_ply_mesh(folder / "a.ply"));
    EXPECT_EQ(read_text(folder / "a.ply"), read_text(folder / "b.ply"));
  }
}

TEST(PlyDamage, EndsInAnInputErrorOrAValidMeshWhateverByteIsChanged) {
  const TemporaryFolder folder;
  Mesh small;
  small.origin = {1.0, 2.0, 3.0};
  for (int i = 0; i < 12; ++i) small.positions.push_back({static_cast<float>(i), 1.0f, 2.0f});
  small.triangles = {{0, 1, 2}, {3, 4, 5}, {9, 10, 11}};
  write_ply(folder / "a.ply", small);
  const std::string whole = read_text(folder / "a.ply");
  int refused = 0;
  for (std::uint64_t trial = 0; trial < 2000; ++trial) {
    CounterRandom random(11, 0, trial);
    std::string damaged = whole;
    const std::uint64_t changes = 1 + random.bits() % 3;
    for (std::uint64_t k = 0; k < changes; ++k) {
      damaged[random.bits() % damaged.size()] = static_cast<char>(random.bits() % 256);
    }
    if (random.bits() % 4 == 0) damaged.resize(random.bits() % damaged.size());
    write_text(folder / "b.ply", damaged);
    try {
      const Mesh mesh = read_ply_mesh(folder / "b.ply");
      for (const auto& triangle : mesh.triangles) {
        for (const std::uint32_t corner : triangle) ASSERT_LT(corner, mesh.positions.size());
      }
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace cornice
