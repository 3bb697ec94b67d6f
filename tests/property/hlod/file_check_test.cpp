// SPDX-License-Identifier: GPL-3.0-or-later
// Hierarchies that keep the format's promises, and those that break one each.
#include "hlod/file_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "hlod/extract.h"
#include "tests/property/hlod/cluster_hierarchy.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace cornice::hlod {
namespace {

using bench::Hierarchy;

Hierarchy sample() {
  test::ClusterOptions options;
  options.root_side_m = 64.0;
  options.finest_level = 2;
  return test::cluster_hierarchy(
      test::height_mesh(0, 0, 32, 2.0, [](double x, double y) { return 0.2 * x + 0.01 * y * y; }),
      options);
}

void write(const std::filesystem::path& path, const Hierarchy& h) {
  FileWriter writer(path, h.header);
  for (std::size_t n = 0; n < h.nodes.size(); ++n) {
    Node node = make_node(h.meshes[n], h.nodes[n].error_m, 0.0f);
    writer.add(node, encode_cell(h.meshes[n], h.header));
  }
  writer.finish();
}

FileCheck checked(const Hierarchy& h) {
  const test::TemporaryFolder folder;
  write(folder / "a.hlod", h);
  return check_file(File(folder / "a.hlod"), 2);
}

/// The first cell of a level.
CellMesh& cell_of(Hierarchy& h, int level) {
  return *std::find_if(h.meshes.begin(), h.meshes.end(),
                       [&](const CellMesh& mesh) { return mesh.key.level == level; });
}

TEST(FileCheck, FindsNothingInASoundHierarchy) {
  const FileCheck check = checked(sample());
  EXPECT_EQ(check.faults(), 0u) << (check.examples.empty() ? "" : check.examples.front());
  EXPECT_EQ(check.cells, 1u + 4u + 16u);
}

TEST(FileCheck, FindsEachBrokenPromise) {
  const auto fault = [](std::uint64_t FileCheck::*count,
                        const std::function<void(Hierarchy&)>& spoil) {
    Hierarchy h = sample();
    spoil(h);
    const FileCheck check = checked(h);
    EXPECT_GT(check.*count, 0u);
    EXPECT_FALSE(check.examples.empty());
  };
  fault(&FileCheck::unlike_triangles, [](Hierarchy& h) { cell_of(h, 1).triangles.pop_back(); });
  fault(&FileCheck::falling_errors, [](Hierarchy& h) { h.nodes.front().error_m = 0.0f; });
  fault(&FileCheck::far_vertices,
        [](Hierarchy& h) { cell_of(h, 0).vertices[5].position.x = -5000; });
  fault(&FileCheck::long_edges, [](Hierarchy& h) { cell_of(h, 0).vertices[5].position.x += 2000; });
  fault(&FileCheck::far_parents, [](Hierarchy& h) { cell_of(h, 1).parents[3].position.y += 600; });
  fault(&FileCheck::double_parents, [](Hierarchy& h) {
    for (CellVertex& parent : cell_of(h, 1).parents) ++parent.position.x;
  });
  fault(&FileCheck::degenerate_triangles, [](Hierarchy& h) {
    CellMesh& cell = cell_of(h, 0);
    cell.triangles.front()[1] = cell.triangles.front()[0];
  });
}

TEST(FileCheck, NamesDamagedBlocks) {
  const test::TemporaryFolder folder;
  write(folder / "a.hlod", sample());
  std::string bytes = test::read_text(folder / "a.hlod");
  const std::uint64_t offset = File(folder / "a.hlod").nodes()[7].offset;
  bytes[offset + 9] = static_cast<char>(bytes[offset + 9] + 1);
  test::write_text(folder / "b.hlod", bytes);
  const FileCheck check = check_file(File(folder / "b.hlod"), 1);
  EXPECT_EQ(check.damaged_blocks, 1u);
}

TEST(Extract, GivesLevelsAndViewsWithSharedVertices) {
  const test::TemporaryFolder folder;
  const Hierarchy h = sample();
  write(folder / "a.hlod", h);
  const File file(folder / "a.hlod");
  const Mesh finest = extract_level(file, 2, 2);
  EXPECT_EQ(finest.triangles.size(), 2u * 32 * 32);
  EXPECT_EQ(finest.positions.size(), 33u * 33);
  EXPECT_EQ(extract_level(file, 0, 1).triangles.size(), file.levels()[0].triangles);
  const Tree tree = make_tree(file.header(), file.nodes());
  const FinePoint eye = fine_eye({-40.0, -40.0, 3.0}, file.header().lattice);
  Radii all;
  all.of[0] = std::int64_t{1} << 29, all.of[1] = std::int64_t{1} << 28;
  settle(all, tree.metric);
  EXPECT_EQ(extract_view(file, tree, all, eye, 2).positions.size(), finest.positions.size());
  const Mesh near = extract_view(file, tree, radii_by_factor(tree.metric, 2.0), eye, 2);
  EXPECT_LE(near.triangles.size(), finest.triangles.size());
  EXPECT_GT(near.triangles.size(), file.levels()[0].triangles);
  EXPECT_EQ(level_for_error(file, 1e9), 0);
  EXPECT_EQ(level_for_error(file, 0.0), 2);
}

}  // namespace
}  // namespace cornice::hlod
