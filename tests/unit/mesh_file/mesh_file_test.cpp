// SPDX-License-Identifier: GPL-3.0-or-later
// OBJ, OFF and STL: nothing of them is lost, and what is wrong is said with its place.
#include "core/io/mesh_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "core/base/error.h"
#include "core/io/mesh_import.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::TemporaryFolder;

class MeshFile : public testing::Test {
 protected:
  void SetUp() override {
    if (!can_import_meshes()) GTEST_SKIP() << "this program was built without OpenMesh";
  }
  Mesh read(const std::string& name, const std::string& text) {
    test::write_text(folder_ / name, text);
    return read_mesh(folder_ / name);
  }
  /// What reading it says.
  std::string fault(const std::string& name, const std::string& text) {
    try {
      read(name, text);
    } catch (const InputError& error) {
      return error.problem();
    }
    return "nothing";
  }
  TemporaryFolder folder_;
};

std::string binary_stl(int triangles, float far = 3) {
  std::string bytes(80, '\0');
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  };
  put(static_cast<std::uint32_t>(triangles));
  for (int t = 0; t < triangles; ++t) {
    for (const float value : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f}) put(value);
    put(far * static_cast<float>(t));
    put(std::uint16_t{0});
  }
  return bytes;
}

TEST_F(MeshFile, ObjKeepsMillimetresOfProjectedCoordinatesAndNonManifoldFaces) {
  const Mesh mesh = read("a.obj",
                         "# mine\nv 2600000.123 1200000.456 700.789\nv 2600001 1200000 700\n"
                         "v 2600000 1200001 700\nv 2600000 1200000 705\nv 2600000 1199999 700\n"
                         "f 1 2 3\nf 2 1 4\nf 1 2 5\nf 1 2 3\nf -5 -4 -3 -2\n");
  ASSERT_EQ(mesh.positions.size(), 5u);
  const Vec3d first = mesh.origin + mesh.positions[0].cast<double>();
  EXPECT_NEAR(first.x, 2600000.123, 1e-6);
  EXPECT_NEAR(first.y, 1200000.456, 1e-6);
  EXPECT_NEAR(first.z, 700.789, 1e-6);
  // Three faces at one edge, one twice, and a polygon: all are there.
  ASSERT_EQ(mesh.triangles.size(), 6u);
  EXPECT_EQ(mesh.triangles[2], (std::array<std::uint32_t, 3>{0, 1, 4}));
  EXPECT_EQ(mesh.triangles[5], (std::array<std::uint32_t, 3>{0, 2, 3}));
}

TEST_F(MeshFile, ObjCarriesNormalsColoursAndTextureWhereEveryVertexHasOne) {
  const std::string head =
      "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvt 0 0.5\nvt 1 0\nvt 0 1\n"
      "vn 0 0 1\n";
  const Mesh mesh = read("a.obj", head + "f 1/1/1 2/2/1 3/3/1\n");
  ASSERT_EQ(mesh.normals.size(), 3u);
  EXPECT_EQ(mesh.normals[1].z, 1.0f);
  ASSERT_EQ(mesh.byte_properties.size(), 3u);
  EXPECT_EQ(mesh.byte_properties[1].name, "green");
  EXPECT_EQ(mesh.byte_properties[1].values[1], 255);
  ASSERT_EQ(mesh.float_properties.size(), 2u);
  EXPECT_EQ(mesh.float_properties[1].values[0], 0.5f);
  // At a seam a vertex has two places in the texture: no one of them is right.
  const Mesh seam = read("b.obj", head + "v 0 0 5\nf 1/1/1 2/2/1 3/3/1\nf 1/2/1 2/3/1 4/1/1\n");
  EXPECT_TRUE(seam.float_properties.empty());
}

TEST_F(MeshFile, OffAndStlOfTextAndBinaryAreRead) {
  const Mesh off =
      read("a.off",
           "OFF\n# four\n4 2 0\n0 0 2600000\n1 0 2600000\n0 1 2600000.125\n1 1 2600001\n"
           "3 0 1 2\n4 0 1 3 2\n");
  EXPECT_EQ(off.positions.size(), 4u);
  EXPECT_EQ(off.triangles.size(), 3u);
  EXPECT_EQ(off.origin.z + double{off.positions[2].z}, 2600000.125);
  std::string text = "solid a\n";
  for (const char* far : {"0", "5"}) {
    text += std::string("facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 ") +
            far + "\nendloop\nendfacet\n";
  }
  for (const Mesh& stl : {read("a.stl", text + "endsolid a\n"), read("b.STL", binary_stl(2))}) {
    EXPECT_EQ(stl.positions.size(), 4u);
    EXPECT_EQ(stl.triangles.size(), 2u);
  }
  EXPECT_NE(fault("c.stl", text).find("line 15"), std::string::npos);
  EXPECT_NE(fault("d.stl", binary_stl(2).substr(0, 150)).find("ends early"), std::string::npos);
}

TEST_F(MeshFile, SaysInWhichLineATextIsWrong) {
  const std::string three = "v 1 0 0\nv 0 1 0\nv 0 0 5\n";
  EXPECT_EQ(fault("a.obj", "v 1 abc 0\n" + three + "f 1 2 3\n"),
            "line 1 has 'abc', which is not a number; repair the mesh");
  EXPECT_NE(fault("a.obj", three + "v 1 nan 0\n").find("line 4"), std::string::npos);
  EXPECT_NE(fault("a.obj", three + "v 1 2\n").find("line 4"), std::string::npos);
  EXPECT_NE(fault("a.obj", three + "f 1 2\n").find("line 4"), std::string::npos);
  EXPECT_NE(fault("a.obj", three + "f 1 x 3\n").find("line 4"), std::string::npos);
  EXPECT_NE(fault("a.obj", three + "f 1 0 3\n").find("line 4"), std::string::npos);
  EXPECT_NE(fault("a.obj", three + "f 1 -9 3\n").find("line 4"), std::string::npos);
  EXPECT_NE(fault("a.obj", three + "f 1 2 9\n").find("vertex 9"), std::string::npos);
  EXPECT_NE(fault("a.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1").find("line 5"), std::string::npos);
  EXPECT_NE(fault("a.off", "OFF\n1 1 0\n0 0 0\n").find("0 of 1 faces"), std::string::npos);
  EXPECT_NE(fault("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n").find("line 4"), std::string::npos);
  for (const char* name : {"e.obj", "e.off", "e.stl"}) {
    EXPECT_NE(fault(name, ""), "nothing");
    EXPECT_NE(fault(name, std::string("\x7f\x01 junk \xff\xfe", 10)), "nothing");
  }
}

TEST_F(MeshFile, KeepsToItsMemory) {
  const std::string text = "v 1 0 0\nv 0 1 0\nv 0 0 5\nf 1 2 3\n";
  test::write_text(folder_ / "a.obj", text);
  EXPECT_THROW(open_mesh_stream(folder_ / "a.obj",
                                {.vertex_bytes = 10, .piece_triangles = 1, .scratch = {}}),
               RunError);
  Mesh piece;
  EXPECT_TRUE(open_mesh_stream(folder_ / "a.obj", {})->next(piece));
  EXPECT_GE(estimated_triangles(folder_ / "a.obj"), 1u);
}

TEST(MeshFileNames, OfUnknownFormatsAreRefusedWithTheKnownOnes) {
  const TemporaryFolder folder;
  test::write_text(folder / "a.fbx", "x");
  try {
    read_mesh(folder / "a.fbx");
    FAIL() << "an unknown format was read";
  } catch (const InputError& error) {
    EXPECT_NE(error.problem().find(".ply"), std::string::npos) << error.problem();
  }
}

}  // namespace
}  // namespace cornice
