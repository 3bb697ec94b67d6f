// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-trim as it is run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/mesh/select.h"
#include "tests/support/full_disk.h"
#include "tests/support/json_file.h"
#include "tests/support/meshes.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;
using test::read_text;

/// 40 m x 40 m of ground, measured at 16 points/m² but for a river of 8 m and one of 16 m.
Mesh ground_with_rivers() {
  Mesh mesh =
      test::height_mesh(0, 0, 80, 0.5, [](double x, double y) { return std::sin(0.2 * x + y); });
  mesh.origin = {2600000.0, 1200000.0, 1000.0};
  mesh.crs_text = "EPSG:2056+5728";
  FloatProperty support{"support", {}}, density{"density", {}};
  for (const Vec3f p : mesh.positions) {
    const float bank = std::max({std::abs(p.x - 8.0f) - 4.0f, 0.0f});
    const float wide_bank = std::max(std::abs(p.x - 28.0f) - 8.0f, 0.0f);
    support.values.push_back(bank > 0.0f && wide_bank > 0.0f ? 0.2f : 3.0f);
    density.values.push_back(16.0f);
  }
  mesh.float_properties = {support, density};
  return mesh;
}

class TrimProgram : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const Mesh& mesh) const {
    write_ply(folder_ / name, mesh);
    return file(name);
  }
  static ProcessResult run(std::vector<std::string> words) {
    words.insert(words.begin(), (fs::path(CORNICE_BIN_DIR) / "cornice-trim").string());
    words.push_back("--no-progress");
    return test::run_process(words);
  }
  /// Expects an error of one line that holds `words`, the exit code, and no output.
  void expect_error(const std::vector<std::string>& arguments, int exit_code,
                    const std::string& words) const {
    const ProcessResult result = run(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_EQ(test::line_count(result.err), 1u) << result.err;
    EXPECT_EQ(result.err.rfind("cornice-trim: error: ", 0), 0u) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(folder_ / "out.ply"));
  }
  test::TemporaryFolder folder_;
};

TEST_F(TrimProgram, KeepsTheNarrowRiverDropsTheWideOneAndReportsBoth) {
  const std::string in = write("in.ply", ground_with_rivers());
  const ProcessResult result = run({in, "-o", file("out.ply"), "--report", file("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Mesh mesh = read_ply_mesh(folder_ / "out.ply");
  EXPECT_EQ(mesh.crs_text, "EPSG:2056+5728");
  EXPECT_EQ(mesh.origin, (Vec3d{2600000.0, 1200000.0, 1000.0}));
  const auto& source = *find_byte_property(mesh, "source");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const float x = mesh.positions[v].x;
    EXPECT_TRUE(x < 20.0f || x > 36.0f);
    EXPECT_EQ(source[v], std::abs(x - 8.0f) <= 4.0f ? 1 : 0) << x;
  }
  const auto report = test::read_json(folder_ / "r.json");
  EXPECT_EQ(report["tool"], "cornice-trim");
  EXPECT_EQ(report["counts"].at("vertices"), mesh.positions.size());
  EXPECT_EQ(report["counts"].at("bridged vertices"), std::count(source.begin(), source.end(), 1));
  EXPECT_EQ(report["parameters"].at("bridge"), 10.0);
  EXPECT_GT(report["quality"].at("dropped_area_m2"), 600.0);
}

TEST_F(TrimProgram, DoesWhatItsOptionsSay) {
  const std::string in = write("in.ply", ground_with_rivers());
  const auto triangles = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{in, "-o", file("out.ply"), "--overwrite"};
    words.insert(words.end(), options.begin(), options.end());
    const ProcessResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_ply_mesh(folder_ / "out.ply").triangles.size();
  };
  const std::size_t all = ground_with_rivers().triangles.size();
  EXPECT_EQ(triangles({"--bridge", "20"}), all);
  EXPECT_LT(triangles({"--bridge", "0"}), triangles({}));
  EXPECT_EQ(triangles({"--bridge", "0", "--max-support", "5", "--spacings", "20"}), all);
  EXPECT_EQ(triangles({"--bridge", "0", "--max-support", "5", "--min-support", "4"}), all);
  EXPECT_EQ(triangles({"--bridge", "0", "--min-area", "1e9"}), triangles({"--bridge", "0"}))
      << "what reaches the tile's edge stays, however small";
}

TEST_F(TrimProgram, TakesSupportFromPointsWhereTheMeshHasNone) {
  Mesh bare = ground_with_rivers();
  bare.float_properties.clear();
  const std::string in = write("in.ply", bare);
  OrientedPoints points;
  points.origin = {2600010.0, 1200000.0, 990.0};
  points.crs_text = bare.crs_text;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    CounterRandom random(5, 1, i);
    const double x = random.uniform(0, 24), y = random.uniform(0, 40);
    points.positions.push_back(Vec3d{x - 10.0, y, std::sin(0.2 * x + y) + 10.0}.cast<float>());
    points.normals.push_back({0, 0, 1});
  }
  write_ply(folder_ / "points.ply", points);
  const ProcessResult result = run({in, "-o", file("out.ply"), "--points", file("points.ply")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Mesh mesh = read_ply_mesh(folder_ / "out.ply");
  ASSERT_FALSE(mesh.triangles.empty());
  float east = 0.0f;
  for (const Vec3f p : mesh.positions) east = std::max(east, p.x);
  EXPECT_NEAR(east, 24.5f, 0.6f);
  points.crs_text = "EPSG:2154+5720";
  write_ply(folder_ / "foreign.ply", points);
  fs::remove(folder_ / "out.ply");
  expect_error({in, "-o", file("out.ply"), "--points", file("foreign.ply")}, 3, "EPSG:2154+5720");
}

TEST_F(TrimProgram, GivesTheSameBytesWithOneThreadAndWithTwo) {
  Mesh mesh = ground_with_rivers();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    CounterRandom random(9, 2, v);
    mesh.float_properties[0].values[v] *= static_cast<float>(random.uniform(0.5, 12.0));
  }
  const std::string in = write("in.ply", mesh);
  ASSERT_EQ(run({in, "-o", file("one.ply"), "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(run({in, "-o", file("two.ply"), "--threads", "2"}).exit_code, 0);
  EXPECT_EQ(read_text(folder_ / "one.ply"), read_text(folder_ / "two.ply"));
}

TEST_F(TrimProgram, PassesEmptyMeshesAndMeshesOfThreePointsOn) {
  Mesh empty;
  empty.crs_text = "EPSG:2056+5728";
  empty.float_properties = {{"support", {}}, {"density", {}}};
  const ProcessResult none = run({write("empty.ply", empty), "-o", file("none.ply")});
  EXPECT_EQ(none.exit_code, 0) << none.err;
  EXPECT_NE(none.err.find("warning: "), std::string::npos) << none.err;
  EXPECT_EQ(read_ply_mesh(folder_ / "none.ply").crs_text, "EPSG:2056+5728");
  EXPECT_NE(find_byte_property(read_ply_mesh(folder_ / "none.ply"), "source"), nullptr);

  Mesh three;
  three.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  three.triangles = {{0, 1, 2}};
  three.float_properties = {{"support", {0.0f, 0.0f, 0.0f}}};
  const std::string in = write("three.ply", three);
  ASSERT_EQ(run({in, "-o", file("three-out.ply")}).exit_code, 0);
  EXPECT_EQ(read_ply_mesh(folder_ / "three-out.ply").triangles.size(), 1u);
  OrientedPoints points;
  points.positions = three.positions;
  points.normals.assign(3, {0, 0, 1});
  write_ply(folder_ / "points.ply", points);
  ASSERT_EQ(run({in, "-o", file("again.ply"), "--points", file("points.ply")}).exit_code, 0);
  EXPECT_EQ(read_ply_mesh(folder_ / "again.ply").triangles.size(), 1u);
}

TEST_F(TrimProgram, RefusesBadInputAndBadOptionsInOneLineEach) {
  const std::string in = write("in.ply", ground_with_rivers());
  const std::vector<std::string> out{"-o", file("out.ply")};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), out.begin(), out.end());
    return words;
  };
  const std::string whole = read_text(folder_ / "in.ply");
  test::write_text(folder_ / "cut.ply", whole.substr(0, whole.size() / 2));
  expect_error(with({file("cut.ply")}), 3, "cut.ply");
  test::write_text(folder_ / "no.ply", "LASF this is no mesh");
  expect_error(with({file("no.ply")}), 3, "no.ply");
  test::write_text(folder_ / "nothing.ply", "");
  expect_error(with({file("nothing.ply")}), 3, "nothing.ply");
  Mesh bare = ground_with_rivers();
  bare.float_properties.clear();
  expect_error(with({write("bare.ply", bare)}), 3, "support");
  write_ply(folder_ / "none.ply", OrientedPoints{});
  expect_error(with({in, "--points", file("none.ply")}), 3, file("none.ply") + ": there are no");
  // The mesh is not to blame for damaged points.
  expect_error(with({in, "--points", file("cut.ply")}), 3, file("cut.ply") + ": its points");
  expect_error(with({file("missing.ply")}), 3, "missing.ply");
  expect_error(with({in, "--min-support", "3", "--max-support", "2"}), 2, "--max-support");
  expect_error(with({in, "--bridge", "-1"}), 2, "--bridge");
  expect_error(with({in, "--fill-dem", file("missing.tif")}), 3, "missing.tif");
  expect_error(with({in, "--fill-dem", in}), 3, "in.ply");
  ASSERT_EQ(run(with({in})).exit_code, 0);
  EXPECT_EQ(run(with({in})).exit_code, 2) << "the output is there already";
}

TEST_F(TrimProgram, LeavesNothingBehindOnAFullDisk) {
  const std::string in = write("in.ply", ground_with_rivers());
  const test::TemporaryFolder small;
  // A program, not a function: what it says is thrown for the helper to take.
  const auto outcome = test::on_full_disk(small.path(), [&] {
    const ProcessResult result = run({in, "-o", (small / "out.ply").string()});
    if (result.exit_code != 0) throw RunError("", result.err);
  });
  if (!outcome) GTEST_SKIP() << "nobody may mount a small disk here";
  EXPECT_NE(outcome->find("cornice-trim: error: "), std::string::npos) << *outcome;
  EXPECT_EQ(outcome->find('|'), std::string::npos) << *outcome;
}

}  // namespace
}  // namespace cornice
