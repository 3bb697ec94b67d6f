// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-remesh as it is run, on a surface that cornice-poisson makes of a wall with noise.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/mesh/quality.h"
#include "core/mesh/surface_distance.h"
#include "core/mesh/topology.h"
#include "tests/support/json_file.h"
#include "tests/support/meshes.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;

const fs::path kBin = CORNICE_BIN_DIR;
constexpr double kBound = 0.05;

ProcessResult remesh(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), (kBin / "cornice-remesh").string());
  arguments.push_back("--no-progress");
  return test::run_process(arguments);
}

/// 24 m x 24 m of rough ground with a step of 6 m across, its wall upright and as rough.
OrientedPoints stepped_ground() {
  OrientedPoints points;
  points.origin = {2600000.0, 1200000.0, 1000.0};
  points.crs_text = "EPSG:2056+5728";
  CounterRandom random(5, 1, 0);
  const auto add = [&](Vec3d p, Vec3d normal) {
    const Vec3d noise{random.normal(), random.normal(), random.normal()};
    points.positions.push_back((p + noise * 0.04).cast<float>());
    points.normals.push_back(normal.cast<float>());
    points.quality.push_back(1.0f);
  };
  for (int i = 0; i < 24 * 24 * 20; ++i) {
    const double x = random.uniform(0, 24), y = random.uniform(0, 24);
    add({x, y, x < 12 ? 6.0 : 0.0}, {0, 0, 1});
  }
  for (int i = 0; i < 24 * 6 * 20; ++i) {
    add({12, random.uniform(0, 24), random.uniform(0, 6)}, {1, 0, 0});
  }
  return points;
}

class RemeshProgram : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    const fs::path points = folder_->path() / "points.ply";
    write_ply(points, stepped_ground());
    const ProcessResult made =
        test::run_process({(kBin / "cornice-poisson").string(), "mesh", points.string(), "-o",
                           surface().string(), "--no-progress"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const ProcessResult done = remesh({surface().string(), "-o", result().string(), "--max-error",
                                       "0.05", "--threads", "1", "--report", report().string()});
    ASSERT_EQ(done.exit_code, 0) << done.err;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static fs::path surface() { return folder_->path() / "surface.ply"; }
  static fs::path result() { return folder_->path() / "result.ply"; }
  static fs::path report() { return folder_->path() / "report.json"; }

  static test::TemporaryFolder* folder_;
};
test::TemporaryFolder* RemeshProgram::folder_ = nullptr;

TEST_F(RemeshProgram, KeepsTheBoundOnARoughStepAndSaysSo) {
  const Mesh before = read_ply_mesh(surface()), after = read_ply_mesh(result());
  EXPECT_LT(after.triangles.size(), before.triangles.size());
  const TriangleTree first(before.positions, before.triangles, 0);
  const TriangleTree second(after.positions, after.triangles, 0);
  EXPECT_LE(static_cast<double>(measure_distance(first, second, 0.06f, 0).hausdorff_m()), kBound);
  const nlohmann::json json = test::read_json(report());
  EXPECT_LE(json.at("quality").at("hausdorff_m").get<double>(), kBound);
  EXPECT_TRUE(json.at("warnings").empty()) << json.at("warnings").dump();
}

TEST_F(RemeshProgram, LeavesNoTriangleWithoutAreaAndNoBadConnection) {
  const Mesh mesh = read_ply_mesh(result());
  const QualityReport quality = measure_quality(mesh.positions, mesh.triangles, 0);
  EXPECT_EQ(quality.without_area, 0u);
  EXPECT_GE(quality.share_min_angle_20(), 0.99);
  EXPECT_TRUE(check_topology(mesh.triangles, mesh.positions.size(), 1).is_manifold());
}

TEST_F(RemeshProgram, SaysHowManyThinTrianglesTouchWhatMayNotMove) {
  const nlohmann::json figures = test::read_json(report()).at("quality");
  const auto below = [&](const char* which) {
    return figures.at(which).at("below_20_deg").get<std::uint64_t>();
  };
  const std::uint64_t all = below("all triangles");
  const nlohmann::json& fixed = figures.at("thin_at_fixed_vertices");
  EXPECT_EQ(fixed.at("triangles").get<std::uint64_t>(),
            all - below("triangles away from fixed vertices"));
  EXPECT_LE(fixed.at("share_of_thin").get<double>(), 1.0);
}

TEST_F(RemeshProgram, KeepsBordersBitForBit) {
  const auto before = test::border_edges(read_ply_mesh(surface()));
  EXPECT_GT(before.size(), 100u);
  EXPECT_EQ(test::border_edges(read_ply_mesh(result())), before);
}

TEST_F(RemeshProgram, WritesTheSameBytesWithTwoThreads) {
  const fs::path two = folder_->path() / "two.ply";
  ASSERT_EQ(
      remesh({surface().string(), "-o", two.string(), "--max-error", "0.05", "--threads", "2"})
          .exit_code,
      0);
  EXPECT_EQ(test::read_text(two), test::read_text(result()));
}

TEST_F(RemeshProgram, TellsOfBadInputInOneLineAndWritesNothing) {
  const std::string whole = test::read_text(surface());
  const fs::path bad = folder_->path() / "bad.ply", out = folder_->path() / "none.ply";
  const auto expect_refused = [&](const std::string& bytes, int exit_code, const char* what) {
    std::ofstream(bad, std::ios::binary) << bytes;
    const ProcessResult r = remesh({bad.string(), "-o", out.string()});
    EXPECT_EQ(r.exit_code, exit_code) << r.err;
    EXPECT_EQ(test::line_count(r.err), 1u) << r.err;
    EXPECT_NE(r.err.find("cornice-remesh: error:"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("bad.ply"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find(what), std::string::npos) << r.err;
    EXPECT_FALSE(fs::exists(out));
  };
  expect_refused(whole.substr(0, whole.size() / 2), 3, "truncated");
  expect_refused("not a mesh", 3, "PLY");
  const fs::path points = folder_->path() / "points.ply";
  expect_refused(test::read_text(points), 3, "no triangles");
  std::string wrong = whole;
  wrong.replace(wrong.size() - 4, 4, "\xff\xff\xff\x7f");
  expect_refused(wrong, 3, "");
  Mesh far = read_ply_mesh(result());
  far.positions[7].z = -3e38f;
  const fs::path mesh = folder_->path() / "far.ply";
  write_ply(mesh, far);
  expect_refused(test::read_text(mesh), 3, "vertex 7 further than");
}

TEST_F(RemeshProgram, RefusesWrongUsage) {
  const fs::path out = folder_->path() / "none.ply";
  EXPECT_EQ(remesh({surface().string()}).exit_code, 2);
  EXPECT_EQ(remesh({surface().string(), "-o", out.string(), "--max-error", "-1"}).exit_code, 2);
  EXPECT_EQ(remesh({surface().string(), "-o", out.string(), "--min-edge", "5", "--max-edge", "1"})
                .exit_code,
            2);
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace cornice
