// SPDX-License-Identifier: GPL-3.0-or-later
// A gap of a survey filled from an elevation model, through cornice-poisson and cornice-trim.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/io/raster.h"
#include "core/mesh/select.h"
#include "core/mesh/topology.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;

constexpr double kWest = 2600000.0, kSouth = 1200000.0;
/// Two tiles of 100 m side by side; the middle of the hole lies on their common border.
constexpr double kTile = 100.0, kHoleX = 100.0, kHoleY = 50.0, kHoleRadius = 30.0;
/// What the elevation model is off the ground: a bias and waves.
constexpr double kBias = 0.25, kWaves = 0.1;

double ground(double x, double y) { return 1000.0 + 0.35 * x - 0.1 * y + std::sin(0.1 * y); }

double from_hole(double x, double y) { return std::hypot(x - kHoleX, y - kHoleY); }

/// Measured points of [west, east] x [-40, 140], 4 per m², 2 cm noise, none in the hole.
OrientedPoints measured(double west, double east) {
  OrientedPoints points;
  points.origin = {kWest, kSouth, 1000.0};
  points.crs_text = "EPSG:2056+5728";
  for (auto i = static_cast<int>(2 * west); i < 2 * east; ++i) {
    for (int j = -80; j < 280; ++j) {
      CounterRandom random(3, 1, static_cast<std::uint64_t>(i + 5000) << 32 | (j + 5000));
      const double x = 0.5 * (i + random.uniform()), y = 0.5 * (j + random.uniform());
      if (from_hole(x, y) < kHoleRadius) continue;
      const double z = ground(x, y) + 0.02 * random.normal() - 1000.0;
      points.positions.push_back(Vec3d{x, y, z}.cast<float>());
      points.normals.push_back(
          normalized(Vec3d{-0.35, 0.1 - 0.1 * std::cos(0.1 * y), 1.0}).cast<float>());
      points.quality.push_back(1.0f);
    }
  }
  return points;
}

void write_model(const fs::path& path, const std::string& crs, double from_x) {
  Raster r;
  r.width = 300;
  r.height = 200;
  r.west = kWest - 50.0;
  r.north = kSouth + 150.0;
  r.step = 1.0;
  r.crs = crs_from_text(crs);
  for (int row = 0; row < r.height; ++row) {
    for (int col = 0; col < r.width; ++col) {
      const double x = col + 0.5 - 50.0, y = 150.0 - row - 0.5;
      const double z = ground(x, y) + kBias + kWaves * std::sin(x) * std::cos(y);
      r.values.push_back(x < from_x ? r.no_data : static_cast<float>(z));
    }
  }
  write_cog(path, r);
}

class FillDem : public testing::Test {
 protected:
  void SetUp() override {
    write_ply(folder_ / "west.points.ply", measured(-40, kTile + 40));
    write_ply(folder_ / "east.points.ply", measured(kTile - 40, 2 * kTile + 40));
    write_model(folder_ / "dem.tif", "EPSG:2056+5728", -1000.0);
  }
  ProcessResult run(const std::string& program, std::vector<std::string> words) const {
    words.insert(words.begin(), (fs::path(CORNICE_BIN_DIR) / program).string());
    words.insert(words.end(), {"--no-progress", "--overwrite"});
    return test::run_process(words);
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  /// Both tiles with the model as `words` say.
  void reconstruct(const std::vector<std::string>& words) const {
    for (const auto& [name, west] : {std::pair{"west", 0.0}, std::pair{"east", kTile}}) {
      const std::string tile = std::to_string(kWest + west) + "," + std::to_string(kSouth) + "," +
                               std::to_string(kWest + west + kTile) + "," +
                               std::to_string(kSouth + kTile);
      std::vector<std::string> solve{"solve",    file(std::string(name) + ".points.ply"),
                                     "-o",       file(std::string(name) + ".field"),
                                     "--tile",   tile,
                                     "--step-m", "1"};
      solve.insert(solve.end(), words.begin(), words.end());
      const ProcessResult solved = run("cornice-poisson", solve);
      ASSERT_EQ(solved.exit_code, 0) << solved.err;
    }
    for (const auto& [name, other] : {std::pair{"west", "east"}, std::pair{"east", "west"}}) {
      const std::string own(name);
      const ProcessResult extracted =
          run("cornice-poisson",
              {"extract", file(own + ".field"), "--neighbours", file(std::string(other) + ".band"),
               "--points", file(own + ".points.ply"), "-o", file(own + ".surface.ply")});
      ASSERT_EQ(extracted.exit_code, 0) << extracted.err;
    }
  }
  Mesh trim(const std::string& name, const std::vector<std::string>& words) const {
    std::vector<std::string> all{file(name + ".surface.ply"), "-o", file(name + ".ply"), "--report",
                                 file(name + ".json")};
    all.insert(all.end(), words.begin(), words.end());
    const ProcessResult trimmed = run("cornice-trim", all);
    EXPECT_EQ(trimmed.exit_code, 0) << trimmed.err;
    return read_ply_mesh(folder_ / (name + ".ply"));
  }
  test::TemporaryFolder folder_;
};

Vec3d place(const Mesh& mesh, std::uint32_t v) {
  return mesh.origin + mesh.positions[v].cast<double>() - Vec3d{kWest, kSouth, 0.0};
}

std::size_t outlines(const Mesh& mesh) {
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 1);
  return border_loops(mesh.triangles, twins, mesh.positions.size()).size();
}

/// Open edges on the common border, with all that their ends carry.
using End = std::tuple<double, double, float, float, float, int>;
std::set<std::pair<End, End>> common_edges(const Mesh& mesh) {
  const auto& source = *find_byte_property(mesh, "source");
  const auto end = [&](std::uint32_t v) {
    const Vec3d p = place(mesh, v);
    const Vec3f n = mesh.normals[v];
    return End{p.y, p.z, n.x, n.y, n.z, source[v]};
  };
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), 1);
  std::set<std::pair<End, End>> edges;
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    const std::uint32_t a = mesh.triangles[h / 3][h % 3],
                        b = mesh.triangles[h / 3][(h % 3 + 1) % 3];
    if (twins[h] != kOpenEdge || place(mesh, a).x != kTile || place(mesh, b).x != kTile) continue;
    edges.insert(std::minmax(end(a), end(b)));
  }
  return edges;
}

TEST_F(FillDem, ClosesAHoleOfSixtyMetresWithinTheModelsAccuracyAndAcrossTiles) {
  reconstruct({"--fill-dem", file("dem.tif")});
  const Mesh west = trim("west", {"--fill-dem", file("dem.tif")});
  const Mesh east = trim("east", {"--fill-dem", file("dem.tif")});
  const auto edges = common_edges(west);
  EXPECT_EQ(edges, common_edges(east));
  EXPECT_GE(edges.size(), 99u);
  for (const Mesh* mesh : {&west, &east}) {
    EXPECT_EQ(outlines(*mesh), 1u) << "a hole inside, or along the rim of the fill";
    EXPECT_TRUE(check_topology(mesh->triangles, mesh->positions.size(), 1).is_manifold());
    const auto& source = *find_byte_property(*mesh, "source");
    const auto& support = *find_float_property(*mesh, "support");
    std::size_t inside = 0, beside = 0;
    double squares = 0.0;
    for (std::uint32_t v = 0; v < mesh->positions.size(); ++v) {
      const Vec3d p = place(*mesh, v);
      const double r = from_hole(p.x, p.y);
      EXPECT_LT(std::abs(p.z - ground(p.x, p.y)), r < kHoleRadius ? kBias + kWaves + 0.05 : 0.12);
      if (r > kHoleRadius + 1) {
        EXPECT_EQ(source[v], 0);
      }
      if (r < kHoleRadius - 4) {
        EXPECT_EQ(source[v], 2);
        EXPECT_GT(support[v], 3.0f) << "support is by measured points";
        ++inside;
      }
      if (r > kHoleRadius + 2) {
        squares += std::pow(p.z - ground(p.x, p.y), 2);
        ++beside;
      }
    }
    EXPECT_GT(inside, 900u);
    EXPECT_LT(std::sqrt(squares / static_cast<double>(beside)), 0.02)
        << "the model must not pull at measured ground";
  }
  const auto report = test::read_json(folder_ / "west.json");
  EXPECT_NEAR(report["quality"].at("model_area_m2"), 0.5 * M_PI * 29.0 * 29.0 * 1.07, 150.0);
}

TEST_F(FillDem, LeavesTheHoleOpenWhereTheModelHasNoDataAndWithoutIt) {
  // The model knows the eastern half alone, from 10 m behind the border on.
  write_model(folder_ / "half.tif", "EPSG:2056+5728", kTile + 10.0);
  reconstruct({"--fill-dem", file("half.tif")});
  const Mesh west = trim("west", {"--fill-dem", file("half.tif")});
  const Mesh east = trim("east", {"--fill-dem", file("half.tif")});
  EXPECT_EQ(common_edges(west), common_edges(east));
  const auto depth = [](const Mesh& mesh) {
    double least = kHoleRadius;
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3d p = place(mesh, v);
      if (std::abs(p.y - kHoleY) < 5) least = std::min(least, from_hole(p.x, p.y));
    }
    return least;
  };
  EXPECT_GT(depth(west), kHoleRadius - 3);
  EXPECT_LT(depth(east), 11.0);
  const Mesh bare = trim("west", {});
  EXPECT_GT(depth(bare), kHoleRadius - 3);
  const auto& source = *find_byte_property(bare, "source");
  EXPECT_EQ(std::count(source.begin(), source.end(), 2), 0);
}

TEST_F(FillDem, RefusesAModelOfAnotherSystemInOneLineThatNamesIt) {
  write_model(folder_ / "other.tif", "EPSG:2154+5720", -1000.0);
  const ProcessResult solved =
      run("cornice-poisson", {"mesh", file("west.points.ply"), "-o", file("m.ply"), "--step-m", "2",
                              "--fill-dem", file("other.tif")});
  EXPECT_EQ(solved.exit_code, 3);
  EXPECT_NE(solved.err.find("other.tif: has EPSG:2154+5720"), std::string::npos) << solved.err;
  reconstruct({});
  const ProcessResult trimmed = run("cornice-trim", {file("west.surface.ply"), "-o", file("t.ply"),
                                                     "--fill-dem", file("other.tif")});
  EXPECT_EQ(trimmed.exit_code, 3);
  EXPECT_EQ(test::line_count(trimmed.err), 1u) << trimmed.err;
  EXPECT_NE(trimmed.err.find("cornice-trim: error: "), std::string::npos) << trimmed.err;
  EXPECT_FALSE(fs::exists(folder_ / "t.ply"));
}

TEST_F(FillDem, WarnsOfHeightsThatReferToSomethingElse) {
  // As ellipsoidal heights in a file that names the plan system alone: 50 m higher.
  Raster raster = read_raster(folder_ / "dem.tif");
  for (float& z : raster.values) z += 50.0f;
  raster.crs = crs_from_text("EPSG:2056");
  write_cog(folder_ / "high.tif", raster);
  reconstruct({});
  const ProcessResult run_high = run("cornice-trim", {file("west.surface.ply"), "-o", file("t.ply"),
                                                      "--fill-dem", file("high.tif")});
  EXPECT_EQ(run_high.exit_code, 0) << run_high.err;
  EXPECT_NE(run_high.err.find("do not say what their heights refer to"), std::string::npos);
  EXPECT_NE(run_high.err.find("no surface lies on that of the rasters"), std::string::npos);
}

TEST_F(FillDem, FillsATileThatHasPointsInItsHaloAlone) {
  write_ply(folder_ / "west.points.ply", measured(kTile, kTile + 40));
  reconstruct({"--fill-dem", file("dem.tif")});
  const Mesh west = trim("west", {"--fill-dem", file("dem.tif")});
  const Mesh east = trim("east", {"--fill-dem", file("dem.tif")});
  EXPECT_EQ(common_edges(west), common_edges(east));
  EXPECT_EQ(outlines(west), 1u);
  for (std::uint32_t v = 0; v < west.positions.size(); ++v) {
    const Vec3d p = place(west, v);
    EXPECT_LT(std::abs(p.z - ground(p.x, p.y)), kBias + kWaves + 0.1);
  }
}

}  // namespace
}  // namespace cornice
