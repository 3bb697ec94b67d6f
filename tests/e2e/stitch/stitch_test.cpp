// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-stitch as it is run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "tests/property/stitch/tiles.h"
#include "tests/support/full_disk.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::CutPlan;
using test::ProcessResult;

ProcessResult run_stitch(const std::vector<fs::path>& tiles,
                         const std::vector<std::string>& arguments) {
  std::vector<std::string> words{(fs::path(CORNICE_BIN_DIR) / "cornice-stitch").string()};
  for (const fs::path& tile : tiles) words.push_back(tile.string());
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.push_back("--no-progress");
  return test::run_process(words);
}

/// Four tiles whose borders disagree by up to 3 cm and are cut differently.
std::vector<fs::path> shifted_tiles(const test::TemporaryFolder& folder) {
  CutPlan plan;
  plan.jitter_m = 0.03;
  plan.cells = [](int column, int row) { return 14 + 4 * column + row; };
  return test::write_tiles(folder.path(), test::cut_tiles(plan));
}

std::size_t outlines(const Mesh& mesh) {
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 1);
  return border_loops(mesh.triangles, twins, mesh.positions.size()).size();
}

TEST(StitchProgram, WritesTilesOfTheSameNamesThatMeet) {
  const test::TemporaryFolder folder;
  const std::vector<fs::path> tiles = shifted_tiles(folder);
  const ProcessResult before = run_stitch(tiles, {"--check"});
  EXPECT_EQ(before.exit_code, 3);
  EXPECT_NE(before.err.find("cornice-stitch: error: "), std::string::npos) << before.err;
  const ProcessResult run = run_stitch(
      tiles, {"-o", (folder / "out").string(), "--report", (folder / "r.json").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::vector<fs::path> stitched;
  for (const fs::path& tile : tiles) {
    stitched.push_back(folder / "out" / tile.filename());
    const Mesh mesh = read_ply_mesh(stitched.back());
    EXPECT_EQ(mesh.crs_text, "EPSG:2056+5728");
    EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
    ASSERT_EQ(mesh.float_properties.size(), 1u);
    EXPECT_EQ(mesh.byte_properties.at(0).name, "source");
  }
  const ProcessResult after = run_stitch(stitched, {"--check"});
  EXPECT_EQ(after.exit_code, 0) << after.err;
  const nlohmann::json report = test::read_json(folder / "r.json");
  for (const char* figure : {"open_edges", "t_vertices", "mismatched_vertices",
                             "non_manifold_edges", "turned_triangles", "degenerate_triangles"}) {
    EXPECT_EQ(report["quality"].at(figure), 0) << figure;
  }
  EXPECT_GT(report["counts"].at("moved vertices"), 50);
  EXPECT_LT(report["quality"].at("largest_move_m"), 0.25);
}

TEST(StitchProgram, WritesOneMeshWithEverySharedVertexOnce) {
  const test::TemporaryFolder folder;
  const std::vector<fs::path> tiles = shifted_tiles(folder);
  const fs::path one = folder / "one.ply";
  ASSERT_EQ(run_stitch(tiles, {"-o", one.string()}).exit_code, 0);
  const Mesh mesh = read_ply_mesh(one);
  const TopologyReport topology = check_topology(mesh.triangles, mesh.positions.size(), 1);
  EXPECT_TRUE(topology.is_manifold());
  EXPECT_EQ(topology.components, 1u);
  EXPECT_EQ(topology.isolated_vertices, 0u);
  EXPECT_EQ(outlines(mesh), 1u);
  EXPECT_EQ(mesh.float_properties.at(0).name, "support");
  EXPECT_EQ(folder.entries(),
            (std::vector<std::string>{"one.ply", "t0.ply", "t1.ply", "t2.ply", "t3.ply"}));

  const fs::path obj = folder / "one.obj";
  ASSERT_EQ(run_stitch(tiles, {"-o", obj.string()}).exit_code, 0);
  std::ifstream lines(obj);
  std::size_t vertices = 0, faces = 0;
  for (std::string line; std::getline(lines, line);) {
    vertices += line.starts_with("v ");
    faces += line.starts_with("f ");
  }
  EXPECT_EQ(vertices, mesh.positions.size());
  EXPECT_EQ(faces, mesh.triangles.size());

  const fs::path glb = folder / "one.glb";
  ASSERT_EQ(run_stitch(tiles, {"-o", glb.string()}).exit_code, 0);
  EXPECT_EQ(test::read_text(glb).substr(0, 4), "glTF");
}

TEST(StitchProgram, WritesTheSameBytesForAnyOrderAndAnyThreads) {
  const test::TemporaryFolder folder;
  std::vector<fs::path> tiles = shifted_tiles(folder);
  ASSERT_EQ(run_stitch(tiles, {"-o", (folder / "a").string(), "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(run_stitch(tiles, {"-o", (folder / "a.ply").string()}).exit_code, 0);
  std::reverse(tiles.begin(), tiles.end());
  ASSERT_EQ(run_stitch(tiles, {"-o", (folder / "b").string(), "--threads", "2"}).exit_code, 0);
  ASSERT_EQ(run_stitch(tiles, {"-o", (folder / "b.ply").string()}).exit_code, 0);
  for (const fs::path& tile : tiles) {
    EXPECT_EQ(test::read_text(folder / "a" / tile.filename()),
              test::read_text(folder / "b" / tile.filename()));
  }
  EXPECT_EQ(test::read_text(folder / "a.ply"), test::read_text(folder / "b.ply"));
}

TEST(StitchProgram, WritesTilesInOtherFormats) {
  const test::TemporaryFolder folder;
  const std::vector<fs::path> tiles = shifted_tiles(folder);
  ASSERT_EQ(run_stitch(tiles, {"-o", (folder / "o").string(), "--format", "obj"}).exit_code, 0);
  ASSERT_EQ(run_stitch(tiles, {"-o", (folder / "g").string(), "--format", "glb"}).exit_code, 0);
  EXPECT_EQ(test::read_text(folder / "o" / "t2.obj").substr(0, 17), "# cornice origin ");
  EXPECT_EQ(test::read_text(folder / "g" / "t2.glb").substr(0, 4), "glTF");
}

TEST(StitchProgram, LeavesShiftedBordersWithoutTolerance) {
  const test::TemporaryFolder folder;
  const std::vector<fs::path> tiles = shifted_tiles(folder);
  const std::string out = (folder / "out").string();
  ASSERT_EQ(run_stitch(tiles, {"-o", out, "--tolerance-m", "0"}).exit_code, 0);
  EXPECT_EQ(read_ply_mesh(folder / "out" / "t1.ply").positions, read_ply_mesh(tiles[1]).positions);
}

TEST(StitchProgram, RefusesCutsOrKeepsTilesThatLieOverEachOtherAsItIsTold) {
  const test::TemporaryFolder folder;
  std::vector<Mesh> meshes = test::cut_tiles(CutPlan{});
  for (const std::size_t east : {1, 3}) meshes[east].origin.x -= 2.0;
  const std::vector<fs::path> tiles = test::write_tiles(folder.path(), meshes);
  const std::string out = (folder / "out").string();
  const ProcessResult refused = run_stitch(tiles, {"-o", out});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_EQ(test::line_count(refused.err), 1u) << refused.err;
  EXPECT_NE(refused.err.find("t1.ply: lies over t0.ply on "), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--overlaps cut"), std::string::npos) << refused.err;
  EXPECT_FALSE(fs::exists(out) && !fs::is_empty(out));
  const ProcessResult kept = run_stitch(tiles, {"-o", out, "--overlaps", "keep"});
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_NE(kept.err.find("both are kept as they are"), std::string::npos) << kept.err;
  const ProcessResult cut =
      run_stitch(tiles, {"-o", out, "--overlaps", "cut", "--overwrite", "--tolerance-m", "1"});
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  for (const Vec3f p : read_ply_mesh(folder / "out" / "t0.ply").positions) EXPECT_LT(p.x, 7.3f);
}

/// A grid of 9 x 9 vertices as another program writes it: doubles, no comments, other attributes.
void write_foreign(const fs::path& path, double east, double step) {
  std::ofstream out(path, std::ios::binary);
  const int cells = static_cast<int>(std::lround(8.0 / step));
  const int side = cells + 1;
  out << "ply\nformat binary_little_endian 1.0\ncomment made elsewhere\nelement vertex "
      << side * side
      << "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
         "element face "
      << cells * cells << "\nproperty list uchar uint vertex_indices\nend_header\n";
  const auto put = [&](auto value) {
    out.write(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double x = east + i * step, y = j * step;
      put(2600000.0 + x);
      put(1200000.0 + y);
      put(1500.0 + 0.1 * std::sin(0.7 * x) + 0.1 * std::cos(0.4 * y));
      put(static_cast<unsigned char>(200));
    }
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      put(static_cast<unsigned char>(4));  // a quadrangle
      for (const int v :
           {j * side + i, j * side + i + 1, (j + 1) * side + i + 1, (j + 1) * side + i}) {
        put(static_cast<std::uint32_t>(v));
      }
    }
  }
}

TEST(StitchProgram, TakesTilesOfOtherProgramsWithDoublesAndWithoutOrigin) {
  const test::TemporaryFolder folder;
  write_foreign(folder / "a.ply", 0.0, 0.5);
  write_foreign(folder / "b.ply", 8.0, 0.25);
  const fs::path one = folder / "one.ply";
  const ProcessResult run =
      run_stitch({folder / "a.ply", folder / "b.ply"},
                 {"-o", one.string(), "--report", (folder / "r.json").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Mesh mesh = read_ply_mesh(one);
  EXPECT_EQ(mesh.triangles.size(), 2u * (16 * 16 + 32 * 32) + 16) << "16 new vertices, 16 more";
  EXPECT_TRUE(check_topology(mesh.triangles, mesh.positions.size(), 1).is_manifold());
  EXPECT_EQ(outlines(mesh), 1u);
  const Vec3d corner = mesh.origin + mesh.positions[0].cast<double>();
  EXPECT_NEAR(corner.x, 2600000.0, 1e-3);
  EXPECT_NEAR(corner.y, 1200000.0, 1e-3);
  const nlohmann::json report = test::read_json(folder / "r.json");
  EXPECT_EQ(report["quality"].at("open_edges"), 0);
  EXPECT_EQ(report["counts"].at("new vertices"), 16);
}

TEST(StitchProgram, LeavesNoHalfFileOnAFullDisk) {
  const test::TemporaryFolder folder;
  CutPlan plan;
  plan.cells = [](int, int) { return 32; };  // 40 kB a tile
  const std::vector<fs::path> tiles = test::write_tiles(folder.path(), test::cut_tiles(plan));
  for (const char* name : {"tiles", "one.ply", "one.obj", "one.glb"}) {
    SCOPED_TRACE(name);
    const test::TemporaryFolder small;
    const auto outcome = test::on_full_disk(small.path(), [&] {
      const ProcessResult run = run_stitch(tiles, {"-o", (small / name).string()});
      if (run.exit_code != 0) throw RunError("", std::to_string(run.exit_code) + " " + run.err);
      throw RunError("", "it fitted");
    });
    if (!outcome) GTEST_SKIP() << "nobody may mount a small disk here";
    EXPECT_EQ(outcome->rfind("1 cornice-stitch: error: ", 0), 0u) << *outcome;
    // Whole tiles may stay in the folder; no single mesh does.
    const std::string left = outcome->substr(std::min(outcome->find('|'), outcome->size()));
    EXPECT_EQ(left, std::string(name) == "tiles" ? "|tiles" : "");
  }
}

TEST(StitchProgram, LeavesWholeTilesAloneWhenKilledAndDoesTheRestWhenRunAgain) {
  const test::TemporaryFolder folder;
  CutPlan plan;
  plan.columns = 3, plan.rows = 3;
  plan.jitter_m = 0.01;
  plan.cells = [](int, int) { return 150; };
  const std::vector<fs::path> tiles = test::write_tiles(folder.path(), test::cut_tiles(plan));
  const fs::path out = folder / "out", fresh = folder / "fresh";
  ASSERT_EQ(run_stitch(tiles, {"-o", fresh.string()}).exit_code, 0);
  // Of low priority, so that a busy machine looks before the program is done.
  std::vector<std::string> words{"nice", "-n", "19",
                                 (fs::path(CORNICE_BIN_DIR) / "cornice-stitch").string()};
  for (const fs::path& tile : tiles) words.push_back(tile.string());
  words.insert(words.end(), {"-o", out.string(), "--no-progress"});
  bool is_whole = true;
  for (int attempt = 0; attempt < 50 && is_whole; ++attempt) {
    fs::remove_all(out);
    test::run_process(words, SIGKILL, (out / "t0.ply").string());
    is_whole = fs::exists(out / tiles.back().filename());
  }
  ASSERT_FALSE(is_whole) << "too fast to be killed in the middle";
  std::size_t left = 0;
  for (const fs::path& tile : tiles) {
    if (!fs::exists(out / tile.filename())) continue;
    EXPECT_TRUE(test::read_text(out / tile.filename()) == test::read_text(fresh / tile.filename()))
        << tile;
    ++left;
  }
  EXPECT_GE(left, 1u);
  words.push_back("--overwrite");
  ASSERT_EQ(test::run_process(words).exit_code, 0);
  for (const fs::path& tile : tiles) {
    EXPECT_TRUE(test::read_text(out / tile.filename()) == test::read_text(fresh / tile.filename()))
        << tile;
  }
}

TEST(StitchProgram, SaysWhichTilesNameNoSystem) {
  const test::TemporaryFolder folder;
  std::vector<Mesh> meshes = test::cut_tiles(CutPlan{});
  meshes[1].crs_text.clear();
  const ProcessResult run =
      run_stitch(test::write_tiles(folder.path(), meshes), {"-o", (folder / "out").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("1 tiles name no CRS"), std::string::npos) << run.err;
}

TEST(StitchProgram, RefusesWhatItCannotStitchInOneLine) {
  const test::TemporaryFolder folder;
  std::vector<Mesh> meshes = test::cut_tiles(CutPlan{});
  meshes[2].crs_text = "EPSG:2154";
  const std::string out = (folder / "out").string();
  const auto expect_error = [&](const std::vector<fs::path>& tiles,
                                const std::vector<std::string>& words, int code,
                                const std::string& text) {
    const ProcessResult run = run_stitch(tiles, words);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_EQ(test::line_count(run.err), 1u) << run.err;
    EXPECT_NE(run.err.find(text), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(out) && !fs::is_empty(out));
  };
  const std::vector<fs::path> tiles = test::write_tiles(folder.path(), meshes);
  expect_error(tiles, {"-o", out}, 3, "EPSG:2154");
  expect_error({tiles[0], tiles[0]}, {"-o", out}, 2, "name");
  expect_error({tiles[0], tiles[1]}, {}, 2, "--output");
  expect_error({tiles[0], tiles[1]}, {"--check", "-o", out}, 2, "--check");
  expect_error({tiles[0], folder / "none.ply"}, {"-o", out}, 3, "none.ply");
  test::write_text(folder / "cut.ply", test::read_text(tiles[1]).substr(0, 4000));
  expect_error({tiles[0], folder / "cut.ply"}, {"-o", out}, 3, "cut.ply");
  test::write_text(folder / "foreign.ply", "LASF this is no mesh");
  expect_error({tiles[0], folder / "foreign.ply"}, {"-o", out}, 3, "foreign.ply");
}

}  // namespace
}  // namespace cornice
