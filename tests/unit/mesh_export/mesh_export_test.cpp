// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/mesh_export.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "tests/support/full_disk.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

Mesh small_tile() {
  Mesh mesh = test::height_mesh(0, 0, 3, 1.0, [](double x, double) { return x; });
  mesh.origin = {2600000, 1200000, 500};
  mesh.crs_text = "EPSG:2056+5728";
  mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
  return mesh;
}

TEST(ExportMesh, WritesObjRelativeToItsFrame) {
  const test::TemporaryFolder folder;
  export_mesh(folder / "a.obj", small_tile(), {2600001, 1200002, 498});
  const std::string text = test::read_text(folder / "a.obj");
  EXPECT_EQ(text.find("# cornice origin 2600001 1200002 498\n# cornice crs EPSG:2056+5728\n"
                      "v -1.0000 -2.0000 2.0000\n"),
            0u);
  EXPECT_NE(text.find("\nf 1//1 2//2 6//6\n"), std::string::npos);
}

TEST(ExportMesh, MovesTheNodeOfGlbIntoItsFrameAndKeepsAttributes) {
  const test::TemporaryFolder folder;
  Mesh mesh = small_tile();
  mesh.byte_properties.push_back({"bridged", std::vector<std::uint8_t>(16, 1)});
  export_mesh(folder / "a.glb", mesh, {2600001, 1200002, 498});
  const std::string bytes = test::read_text(folder / "a.glb");
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  const auto json = nlohmann::json::parse(bytes.substr(20, length));
  EXPECT_EQ(json["nodes"][0]["translation"], nlohmann::json({-1.0, 2.0, 2.0}));
  EXPECT_TRUE(json["meshes"][0]["primitives"][0]["attributes"].contains("_BRIDGED"));
}

TEST(ExportMesh, WritesGlbThatSaysItsOriginAndHoldsItsNumbers) {
  const test::TemporaryFolder folder;
  const Mesh mesh = small_tile();
  export_mesh(folder / "a.glb", mesh);
  const std::string bytes = test::read_text(folder / "a.glb");
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  };
  ASSERT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(number(4), 2u);
  EXPECT_EQ(number(8), bytes.size());
  const auto json = nlohmann::json::parse(bytes.substr(20, number(12)));
  EXPECT_EQ(json["nodes"][0]["extras"]["origin"][0], 2600000.0);
  EXPECT_EQ(json["nodes"][0]["extras"]["crs"], "EPSG:2056+5728");
  EXPECT_EQ(json["accessors"][0]["count"], 16);
  EXPECT_EQ(json["accessors"][2]["count"], 54);
  // East, up, south.
  const std::size_t data = 20 + number(12) + 8;
  float last[3];
  std::memcpy(last, bytes.data() + data + 15 * 12, 12);
  EXPECT_EQ(last[0], 3.0f);
  EXPECT_EQ(last[1], 3.0f);
  EXPECT_EQ(last[2], -3.0f);
}

TEST(ExportMesh, SaysThatTheDiskIsFull) {
  for (const char* const name : {"a.obj", "a.glb"}) {
    const test::TemporaryFolder folder;
    const auto outcome = test::on_full_disk(folder.path(), [&] {
      export_mesh(folder / name,
                  test::height_mesh(0, 0, 100, 1.0, [](double, double) { return 0; }), {});
    });
    if (!outcome) GTEST_SKIP() << "this machine does not let a test mount a small disk";
    EXPECT_EQ(*outcome, (folder / name).string() +
                            ": cannot be written: the disk is full; free some space or write "
                            "elsewhere, then run again");
  }
}

TEST(ExportMesh, WritesMeshesWithoutTrianglesAndRefusesOtherNames) {
  const test::TemporaryFolder folder;
  export_mesh(folder / "none.glb", Mesh{});
  EXPECT_EQ(test::read_text(folder / "none.glb").substr(0, 4), "glTF");
  EXPECT_THROW(export_mesh(folder / "a.stl", small_tile()), UsageError);
}

}  // namespace
}  // namespace cornice
