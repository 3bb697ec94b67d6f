// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-compare as a user runs it, on ground whose overhangs are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/io/ply.h"
#include "core/io/raster.h"
#include "core/mesh/select.h"
#include "core/mesh/triangle_tree.h"
#include "stages/simulate/scene.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

constexpr double kEast = 2600000.0, kNorth = 1200000.0;
const char* const kCrs = "EPSG:2056+5728";

std::unique_ptr<simulate::Scene> scene_of(const std::string& name, double side_m) {
  simulate::SceneOptions options;
  options.file = fs::path(CORNICE_SOURCE_DIR) / "samples/scenes" / (name + ".yaml");
  options.extent = {kEast - 0.5 * side_m, kNorth - 0.5 * side_m, kEast + 0.5 * side_m,
                    kNorth + 0.5 * side_m};
  return simulate::Scene::build(options);
}

ProcessResult run_compare(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(CORNICE_BIN_DIR) + "/cornice-compare");
  arguments.push_back("--no-progress");
  return run_process(arguments);
}

/// A DEM and the true surface of a piece of a scene, 0.5 m both.
class Pair {
 public:
  Pair(const std::string& scene, double side_m, const Box2d& window)
      : scene_(scene_of(scene, side_m)) {
    Raster dem = scene_->ground_dem(0.5, window);
    dem.crs = crs_from_text(kCrs);
    write_cog(dem_path(), dem);
    mesh_ = scene_->ground_mesh(0.5, window);
    mesh_.crs_text = kCrs;
    write_ply(mesh_path(), mesh_);
  }
  fs::path dem_path() const { return folder_ / "dem.tif"; }
  fs::path mesh_path() const { return folder_ / "mesh.ply"; }
  fs::path operator/(const std::string& name) const { return folder_ / name; }
  const simulate::Scene& scene() const { return *scene_; }
  const Mesh& mesh() const { return mesh_; }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<simulate::Scene> scene_;
  Mesh mesh_;
};

/// The wall of `cliff` with the arch before it.
const Pair& cliff() {
  static const Pair pair("cliff", 150.0,
                         {kEast - 65.0, kNorth - 55.0, kEast - 25.0, kNorth + 55.0});
  return pair;
}

/// A page that stands alone, and files that others read.
void expect_readable_files(const fs::path& out) {
  const std::string page = read_text(out / "index.html");
  EXPECT_THAT(page, HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_EQ(page.find("src=\"http"), std::string::npos);
  EXPECT_EQ(page.find("href="), std::string::npos);
  EXPECT_EQ(read_text(out / "overhangs.gpkg").substr(0, 15), "SQLite format 3");
  const Raster difference = read_raster(out / "difference.tif");
  EXPECT_EQ(difference.width, 80);
  EXPECT_EQ(difference.height, 220);
  EXPECT_EQ(difference.crs.text(), kCrs);
  const Mesh coloured = read_ply_mesh(out / "coloured_b" / "mesh.ply");
  ASSERT_NE(find_float_property(coloured, "difference"), nullptr);
  ASSERT_NE(find_byte_property(coloured, "red"), nullptr);
  for (const char* file :
       {"difference.png", "distance_a.png", "distance_b.png", "overhangs_b.png"}) {
    EXPECT_GT(fs::file_size(out / file), 10000u) << file;
  }
  EXPECT_THAT(read_text(out / "profile_1.svg"), HasSubstr("</svg>"));
  const std::string csv = read_text(out / "statistics.csv");
  EXPECT_THAT(csv, HasSubstr("b_to_a,slope,over 90,"));
  const std::string overhangs = read_text(out / "overhangs.csv");
  EXPECT_EQ(line_count(overhangs),
            1u + read_json(out / "comparison.json")["b"]["overhangs"].get<std::size_t>());
}

TEST(CorniceCompare, FindsTheOverhangsThatTheSimulatorPutThere) {
  const fs::path out = cliff() / "found";
  const ProcessResult run =
      run_compare({cliff().dem_path(), cliff().mesh_path(), "-o", out, "--profile",
                   std::to_string(kEast - 45.0) + "," + std::to_string(kNorth - 60.0) + "," +
                       std::to_string(kEast - 45.0) + "," + std::to_string(kNorth + 60.0)});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(out / "comparison.json");
  EXPECT_EQ(result["a"]["overhangs"], 0);
  // Truth: finer triangles, and the direction of the analytic ground at their centres.
  const Mesh fine =
      cliff().scene().ground_mesh(0.4, {kEast - 64.0, kNorth - 54.0, kEast - 26.0, kNorth + 54.0});
  const Mesh coloured = read_ply_mesh(out / "coloured_b" / "mesh.ply");
  const std::vector<std::uint8_t>* overhang = find_byte_property(coloured, "overhang");
  ASSERT_NE(overhang, nullptr);
  std::vector<Triangle> marked;
  for (const Triangle& t : coloured.triangles) {
    if ((*overhang)[t[0]] != 0 && (*overhang)[t[1]] != 0 && (*overhang)[t[2]] != 0) {
      marked.push_back(t);
    }
  }
  const TriangleTree tree(coloured.positions, marked, 1);
  double truth_m2 = 0.0, found_m2 = 0.0;
  for (const Triangle& t : fine.triangles) {
    const Vec3f centre =
        (fine.positions[t[0]] + fine.positions[t[1]] + fine.positions[t[2]]) * (1.0f / 3.0f);
    Vec3d gradient;
    cliff().scene().ground_value(fine.origin + centre.cast<double>(), &gradient);
    if (!(gradient.z < 0.0)) continue;
    const double area = triangle_area(fine, t);
    truth_m2 += area;
    const Vec3d here = fine.origin + centre.cast<double>() - coloured.origin;
    NearestQuery query;
    query.max_distance_sq = 0.15f * 0.15f;
    if (tree.nearest(here.cast<float>(), query).found()) found_m2 += area;
  }
  expect_readable_files(out);
  EXPECT_GT(truth_m2, 1000.0);
  EXPECT_GE(found_m2 / truth_m2, 0.95);
  EXPECT_NEAR(result["b"]["overhang_m2"].get<double>() / truth_m2, 1.0, 0.08);
  EXPECT_GT(result["b"]["layered_m2"].get<double>(), 200.0);
}

TEST(CorniceCompare, FindsNoOverhangInAValley) {
  const Pair valley("valley", 150.0, {kEast - 40.0, kNorth - 40.0, kEast + 40.0, kNorth + 40.0});
  const ProcessResult run = run_compare(
      {valley.dem_path(), valley.mesh_path(), "-o", valley / "out", "--min-overhang", "0"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(valley / "out" / "comparison.json");
  EXPECT_EQ(result["b"]["overhangs"], 0);
  EXPECT_EQ(result["b"]["layered_m2"], 0.0);
  // The DEM is that of the same ground.
  EXPECT_LT(result["statistics"]["vertical"]["all"]["rms_m"], 0.01);
  EXPECT_LT(result["statistics"]["b_to_a"]["all"]["rms_m"], 0.01);
}

TEST(CorniceCompare, MeasuresPointsOffTheAnalyticGroundToAMillimetre) {
  // Where the ground bends little a point 0.3 m along its normal is 0.3 m from its triangles.
  OrientedPoints points;
  points.origin = cliff().mesh().origin;
  points.crs_text = kCrs;
  for (std::size_t v = 0; v < cliff().mesh().positions.size(); v += 7) {
    points.positions.push_back(cliff().mesh().positions[v] + cliff().mesh().normals[v] * 0.3f);
    points.normals.push_back(cliff().mesh().normals[v]);
  }
  write_ply(cliff() / "off.ply", points);
  const fs::path out = cliff() / "analytic";
  const ProcessResult run = run_compare({cliff().mesh_path(), cliff() / "off.ply", "-o", out});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json all = read_json(out / "comparison.json")["statistics"]["b_to_a"]["all"];
  EXPECT_NEAR(all["median_m"].get<double>(), 0.3, 0.001);
  EXPECT_LT(all["nmad_m"].get<double>(), 0.001);
  EXPECT_GT(all["count"].get<double>(), 2000.0);
}

TEST(CorniceCompare, WritesTheSameBytesWithOneAndWithTwoThreads) {
  std::map<std::string, std::string> bytes[2];
  const fs::path out = cliff() / "threads";
  for (const int threads : {1, 2}) {
    const ProcessResult run = run_compare({cliff().dem_path(), cliff().mesh_path(), "-o", out,
                                           "--threads", std::to_string(threads), "--overwrite"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      if (!entry.is_regular_file()) continue;
      bytes[threads - 1][fs::relative(entry.path(), out)] = read_text(entry.path());
    }
  }
  ASSERT_GT(bytes[0].size(), 10u);
  ASSERT_EQ(bytes[0].size(), bytes[1].size());
  for (const auto& [name, content] : bytes[0]) EXPECT_TRUE(content == bytes[1][name]) << name;
}

TEST(CorniceCompare, EndsBadInputInOneLineAndTheRightCode) {
  const TemporaryFolder folder;
  Raster raster;
  raster.width = raster.height = 20;
  raster.west = kEast, raster.north = kNorth;
  raster.values.assign(400, 500.0f);
  raster.crs = crs_from_text(kCrs);
  write_cog(folder / "dem.tif", raster);
  write_cog(folder / "other.tif", raster);
  raster.crs = crs_from_text("EPSG:2154");
  write_cog(folder / "lambert.tif", raster);
  write_text(folder / "junk.ply", "ply\nformat ascii 1.0\nelement vertex -4\nend_header\n");
  const auto fails = [&](std::vector<std::string> arguments, int code, const std::string& says) {
    arguments.insert(arguments.end(), {"-o", (folder / "never").string()});
    const ProcessResult run = run_compare(arguments);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_EQ(line_count(run.err), 1u) << run.err;
    EXPECT_THAT(run.err, HasSubstr("cornice-compare: error: "));
    EXPECT_THAT(run.err, HasSubstr(says));
    EXPECT_FALSE(fs::exists(folder / "never")) << says;
  };
  const std::string dem = folder / "dem.tif", mesh = folder / "other.tif";
  fails({dem, folder / "lambert.tif"}, 3, "another coordinate system");
  fails({dem, folder / "junk.ply"}, 3, "junk.ply");
  fails({dem, folder / "missing.ply"}, 3, "missing.ply");
  fails({dem, mesh, "--profile", "1,2,3"}, 2, "--profile");
  fails({dem, mesh, "--profile", "1,2,3,4x"}, 2, "--profile");
  fails({dem, mesh, "--profile", "0,0,10,10"}, 2, "outside the common ground");
  fails({dem, mesh, "--spacing", "0"}, 2, "--spacing");
  fails({dem}, 2, "B");
}

TEST(CorniceCompare, IsKnownToTheFrontProgramAndNamesItsUnits) {
  const ProcessResult run =
      run_process({std::string(CORNICE_BIN_DIR) + "/cornice", "compare", "--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("--max-distance"));
  EXPECT_THAT(run.out, HasSubstr(" m"));
}

}  // namespace
}  // namespace cornice::test
