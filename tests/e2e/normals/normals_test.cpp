// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-normals as it is run: simulated tiles with their truth, and real ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "core/io/las.h"
#include "core/io/ply.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;

const fs::path kBin = CORNICE_BIN_DIR;
const fs::path kData = CORNICE_TEST_DATA;

ProcessResult run_normals(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), (kBin / "cornice-normals").string());
  arguments.push_back("--no-progress");
  return test::run_process(arguments);
}

std::vector<fs::path> files_ending(const fs::path& folder, const std::string& ending) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().string().ends_with(ending)) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// A cliff of two tiles side by side, 80 m each, and its true flight lines.
class NormalsOfACliff : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    const fs::path scene = fs::path(CORNICE_SOURCE_DIR) / "samples" / "scenes" / "cliff.yaml";
    const ProcessResult run = test::run_process(
        {(kBin / "cornice-simulate").string(), scene.string(), "-o", (*folder_ / "survey").string(),
         "--tiles", "2x1", "--tile-size", "80", "--density", "15", "--scanner", "palmer",
         "--truth-dem-step", "0", "--no-progress"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static fs::path survey() { return *folder_ / "survey"; }
  static fs::path tile(std::size_t i) { return files_ending(survey(), ".laz").at(i); }
  static std::string lines() { return (survey() / "truth" / "lines.json").string(); }
  static fs::path output(const std::string& name) { return *folder_ / name; }

 private:
  static inline test::TemporaryFolder* folder_ = nullptr;
};

TEST_F(NormalsOfACliff, PointOutOfTheGround) {
  const ProcessResult run =
      run_normals({tile(0).string(), "--neighbours", tile(0).string(), tile(1).string(),
                   "--flightlines", lines(), "-o", output("a.ply").string(), "--las",
                   output("a.laz").string(), "--report", output("a.json").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const OrientedPoints points = read_ply_points(output("a.ply"));
  const OrientedPoints truth = read_ply_points(files_ending(survey() / "truth", ".points.ply")[0]);
  const PointCloud cloud = read_las(read_las_info(tile(0))).points;
  ASSERT_EQ(truth.normals.size(), cloud.size());
  std::map<std::tuple<float, float, float>, Vec3f> expected;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3f p = cloud.positions[i];
    expected[{p.x, p.y, p.z}] = truth.normals[i];
  }
  ASSERT_EQ(points.origin, cloud.origin);
  std::size_t right = 0, overhang = 0, overhang_right = 0;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const Vec3f p = points.positions[i], t = expected.at({p.x, p.y, p.z});
    const bool is_right = dot(points.normals[i], t) > 0.0f;
    right += is_right;
    overhang += t.z < 0.0f;
    overhang_right += t.z < 0.0f && is_right;
  }
  const auto count = static_cast<double>(points.positions.size());
  EXPECT_GT(count, 0.99 * static_cast<double>(cloud.size()));
  EXPECT_GT(static_cast<double>(right), 0.999 * count);
  EXPECT_GT(overhang, 50u);
  EXPECT_GE(static_cast<double>(overhang_right), 0.99 * static_cast<double>(overhang));
  const nlohmann::json counts = test::read_json(output("a.json"))["counts"];
  EXPECT_EQ(counts["points"], points.positions.size());
  EXPECT_GT(counts["halo left out"], 1000);
  EXPECT_EQ(counts["without flight line"], 0);
}

TEST_F(NormalsOfACliff, AreCopiedToTheLasFileWithEverythingElse) {
  ASSERT_EQ(run_normals({tile(0).string(), "--flightlines", lines(), "-o", output("b.ply").string(),
                         "--las", output("b.laz").string()})
                .exit_code,
            0);
  const LasInfo info = read_las_info(output("b.laz"));
  ASSERT_EQ(info.extra_bytes.size(), 5u);
  EXPECT_EQ(info.extra_bytes[2].name, "normal z");
  LasReadOptions all;
  all.attributes = Attribute::kAll;
  const PointCloud copy = read_las(info, all).points;
  EXPECT_EQ(copy.size(), read_ply_points(output("b.ply")).positions.size());
  EXPECT_TRUE(std::any_of(copy.gps_time_s.begin(), copy.gps_time_s.end(),
                          [](double t) { return t > 0.0; }));
}

TEST_F(NormalsOfACliff, AreTheSameBytesWithOneAndTwoThreads) {
  std::vector<std::string> ply_bytes, laz_bytes;
  for (const std::string threads : {"1", "2"}) {
    const fs::path ply = output("t" + threads + ".ply"), laz = output("t" + threads + ".laz");
    ASSERT_EQ(
        run_normals({tile(0).string(), "--neighbours", tile(1).string(), "--flightlines", lines(),
                     "-o", ply.string(), "--las", laz.string(), "--threads", threads})
            .exit_code,
        0);
    ply_bytes.push_back(test::read_text(ply));
    laz_bytes.push_back(test::read_text(laz));
  }
  EXPECT_GT(ply_bytes[0].size(), 1000000u);
  EXPECT_GT(laz_bytes[0].size(), 500000u);
  // Not EXPECT_EQ: it would print megabytes.
  EXPECT_TRUE(ply_bytes[0] == ply_bytes[1]);
  EXPECT_TRUE(laz_bytes[0] == laz_bytes[1]);
}

TEST_F(NormalsOfACliff, NeedInputThatIsThereAndOptionsInRange) {
  const std::string out = output("never.ply").string();
  EXPECT_EQ(run_normals({tile(0).string(), "--flightlines", "nowhere.json", "-o", out}).exit_code,
            3);
  EXPECT_EQ(run_normals({"nowhere.laz", "--flightlines", lines(), "-o", out}).exit_code, 3);
  EXPECT_EQ(
      run_normals({tile(0).string(), "--flightlines", lines(), "-o", out, "--k", "2"}).exit_code,
      2);
  EXPECT_EQ(run_normals({tile(0).string(), "-o", out}).exit_code, 2);
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(NormalsOfACliff, NameTheClassesThatAreThereWhereTheRulesKeepNone) {
  const ProcessResult result =
      run_normals({tile(0).string(), "--flightlines", lines(), "-o", output("none.ply").string(),
                   "--classes", "6", "--report", output("none.json").string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("no points are left: there are "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find(" of class 2"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("the class rules (--classes) keep none of these"), std::string::npos);
  const nlohmann::json quality = test::read_json(output("none.json"))["quality"];
  EXPECT_GT(quality["left out by class"]["2"], 1000);
  EXPECT_TRUE(quality["kept by class"].empty());
}

TEST_F(NormalsOfACliff, RefuseATileInDegrees) {
  const ProcessResult result = run_normals({tile(0).string(), "--flightlines", lines(), "-o",
                                            output("d.ply").string(), "--crs", "EPSG:4326"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.err.find("is in degrees (EPSG:4326); reproject it to metres first"),
            std::string::npos)
      << result.err;
}

TEST_F(NormalsOfACliff, RefuseANeighbourInAnotherCoordinateSystem) {
  const fs::path foreign = kData / "ign_mnx" / "corse.laz";
  if (!fs::exists(foreign)) GTEST_SKIP() << "the folder of real data is not there";
  const ProcessResult run =
      run_normals({tile(0).string(), "--neighbours", foreign.string(), "--flightlines", lines(),
                   "-o", output("never.ply").string()});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("coordinate system"), std::string::npos) << run.err;
}

TEST_F(NormalsOfACliff, RefuseATileThatHoldsFewerPointsThanItPromises) {
  std::string bytes = test::read_text(tile(0));
  ASSERT_EQ(bytes[25], 2) << "LAS 1.2 has the number of points in bytes 107 to 110";
  bytes[110] = static_cast<char>(0xf0);
  const fs::path file = output("promises.laz");
  test::write_text(file, bytes);
  const ProcessResult run =
      run_normals({file.string(), "--flightlines", lines(), "-o", output("never.ply").string()});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find(file.string() + ": is cut short: the header announces 40"),
            std::string::npos)
      << run.err;
}

TEST(NormalsOfARealCliff, AreSettledAndFaceTheBeams) {
  const fs::path tile = kData / "ign_mnx" / "corse.laz";
  if (!fs::exists(tile)) GTEST_SKIP() << "the folder of real data is not there";
  const test::TemporaryFolder folder;
  const ProcessResult lines =
      test::run_process({(kBin / "cornice-flightlines").string(), tile.string(), "-o",
                         (folder / "lines.gpkg").string(), "--no-progress"});
  ASSERT_EQ(lines.exit_code, 0) << lines.err;
  const ProcessResult run =
      run_normals({tile.string(), "--flightlines", (folder / "lines.gpkg").string(), "-o",
                   (folder / "points.ply").string(), "--report", (folder / "r.json").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json counts = test::read_json(folder / "r.json")["counts"];
  EXPECT_GT(counts["points"], 29000);
  EXPECT_LT(counts["unsettled"], 30);
  EXPECT_EQ(counts["without flight line"], 0);
  // The sea and the ledges look up, the walls to the side, and little of the rock hangs over.
  const OrientedPoints points = read_ply_points(folder / "points.ply");
  const auto down = std::count_if(points.normals.begin(), points.normals.end(),
                                  [](Vec3f n) { return n.z < -0.3f; });
  EXPECT_LT(static_cast<double>(down), 0.02 * static_cast<double>(points.normals.size()));
}

}  // namespace
}  // namespace cornice
