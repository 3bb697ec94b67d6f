// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces of a PLY are what the reader of whole meshes reads.
#include "core/io/mesh_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/io/ply.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::TemporaryFolder;

/// Triangles as they are, by the values of their corners.
std::vector<float> soup_of(const Mesh& mesh) {
  std::vector<float> soup;
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) {
      const Vec3f p = mesh.positions.at(v);
      soup.insert(soup.end(), {p.x, p.y, p.z});
      if (!mesh.normals.empty()) soup.push_back(mesh.normals.at(v).x);
      for (const FloatProperty& f : mesh.float_properties) soup.push_back(f.values.at(v));
      for (const ByteProperty& b : mesh.byte_properties) soup.push_back(b.values.at(v));
    }
  }
  return soup;
}

void expect_pieces_are_the_whole(const std::filesystem::path& path, std::uint64_t vertex_bytes) {
  const Mesh whole = read_ply_mesh(path);
  const TemporaryFolder scratch;
  const auto stream = open_ply_mesh_stream(
      path, {.vertex_bytes = vertex_bytes, .piece_triangles = 100, .scratch = scratch.path()});
  for (int round = 0; round < 2; ++round) {
    std::vector<float> soup;
    Mesh piece;
    std::size_t left = whole.triangles.size();
    while (stream->next(piece)) {
      EXPECT_EQ(piece.triangles.size(), std::min<std::size_t>(left, 100));
      left -= piece.triangles.size();
      EXPECT_EQ(piece.origin.x, whole.origin.x);
      EXPECT_EQ(piece.origin.z, whole.origin.z);
      EXPECT_EQ(piece.crs_text, whole.crs_text);
      EXPECT_LE(piece.positions.size(), 3 * piece.triangles.size());
      const std::vector<float> part = soup_of(piece);
      soup.insert(soup.end(), part.begin(), part.end());
    }
    EXPECT_EQ(left, 0u);
    EXPECT_TRUE(soup == soup_of(whole)) << "round " << round;
    stream->rewind();
  }
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
}

Mesh rich_mesh() {
  Mesh mesh = test::height_mesh(3, 4, 30, 1, [](double x, double y) { return std::sin(x + y); });
  mesh.origin = {2'600'000, 1'200'000, 500};
  mesh.crs_text = "EPSG:2056";
  FloatProperty support{"support", {}};
  ByteProperty source{"source", {}};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    mesh.normals.push_back(normalized(Vec3f{0.01f * static_cast<float>(v % 7), 0, 1}));
    support.values.push_back(static_cast<float>(v));
    source.values.push_back(static_cast<std::uint8_t>(v));
  }
  mesh.float_properties = {support};
  mesh.byte_properties = {source};
  return mesh;
}

TEST(MeshStream, GivesTheWholeMeshWhetherItsVerticesFitOrNot) {
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", rich_mesh());
  for (const std::uint64_t bytes : {1u << 30, 20'000u, 500u}) {
    expect_pieces_are_the_whole(folder / "a.ply", bytes);
  }
}

TEST(MeshStream, TakesFacesInAnyOrder) {
  Mesh mesh = rich_mesh();
  for (std::size_t i = mesh.triangles.size() - 1; i > 0; --i) {
    std::swap(mesh.triangles[i], mesh.triangles[CounterRandom(1, 2, i).bits() % (i + 1)]);
  }
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", mesh);
  expect_pieces_are_the_whole(folder / "a.ply", 9'000);
}

TEST(MeshStream, TakesTextDoublesPolygonsAndFacesBeforeVertices) {
  const TemporaryFolder folder;
  std::string vertices, faces;
  for (int v = 0; v < 400; ++v) {
    vertices += std::to_string(2'600'000.25 + v % 20) + " " + std::to_string(1'200'000 + v / 20) +
                " " + std::to_string(v % 13) + "\n";
  }
  int count = 0;
  for (int v = 0; v + 21 < 400; v += 2, ++count) {
    faces += "5 " + std::to_string(v) + " " + std::to_string(v + 1) + " " + std::to_string(v + 21) +
             " " + std::to_string(v + 20) + " " + std::to_string((v * 37) % 400) + "\n";
  }
  const std::string vertex_head =
      "element vertex 400\nproperty double x\nproperty double y\nproperty double z\n";
  const std::string face_head =
      "element face " + std::to_string(count) + "\nproperty list uchar int vertex_indices\n";
  test::write_text(folder / "a.ply", "ply\nformat ascii 1.0\n" + vertex_head + face_head +
                                         "end_header\n" + vertices + faces);
  test::write_text(folder / "b.ply", "ply\nformat ascii 1.0\n" + face_head + vertex_head +
                                         "end_header\n" + faces + vertices);
  for (const char* name : {"a.ply", "b.ply"}) {
    expect_pieces_are_the_whole(folder / name, 1 << 20);
    expect_pieces_are_the_whole(folder / name, 3'000);
  }
}

TEST(MeshStream, RefusesWhatTheReaderOfWholeMeshesRefuses) {
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", rich_mesh());
  const std::string bytes = test::read_text(folder / "a.ply");
  test::write_text(folder / "cut.ply", bytes.substr(0, bytes.size() - 40));
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
  test::write_text(folder / "far.ply", head + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 0 1 4\n");
  test::write_text(folder / "nan.ply", head + "0 0 0\n1 0 0\n0 nan 0\n1 1 0\n3 0 1 2\n3 0 1 3\n");
  for (const char* name : {"cut.ply", "far.ply", "nan.ply"}) {
    for (const std::uint64_t room : {1u << 30, 60u}) {
      const auto read_all = [&] {
        const auto stream = open_ply_mesh_stream(
            folder / name, {.vertex_bytes = room, .piece_triangles = 100, .scratch = {}});
        Mesh piece;
        while (stream->next(piece)) continue;
      };
      EXPECT_THROW(read_all(), InputError) << name;
    }
  }
  write_ply(folder / "none.ply", Mesh{});
  Mesh piece;
  EXPECT_FALSE(open_ply_mesh_stream(folder / "none.ply", {})->next(piece));
  EXPECT_THROW(open_ply_mesh_stream(folder / "gone.ply", {}), InputError);
}

}  // namespace
}  // namespace cornice
