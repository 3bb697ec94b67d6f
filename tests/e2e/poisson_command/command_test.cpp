// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-poisson as it is run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/random.h"
#include "core/io/ply.h"
#include "core/mesh/topology.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ProcessResult;

const fs::path kBin = CORNICE_BIN_DIR;

ProcessResult poisson(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), (kBin / "cornice-poisson").string());
  arguments.push_back("--no-progress");
  return test::run_process(arguments);
}

constexpr double kWest = 2600000.0, kSouth = 1200000.0;

/// Points on a rolling ground at `density` points/m² over [west, east] x [south, north], given from
/// the corner of the survey.
OrientedPoints ground(double west, double south, double east, double north, double density,
                      std::uint64_t seed = 1) {
  OrientedPoints points;
  points.origin = {kWest, kSouth, 1000.0};
  points.crs_text = "EPSG:2056+5728";
  // The same points wherever they are asked for: one in each square of a common grid.
  const double side = 1.0 / std::sqrt(density);
  for (auto i = static_cast<int>(std::floor(west / side)); i * side < east; ++i) {
    for (auto j = static_cast<int>(std::floor(south / side)); j * side < north; ++j) {
      CounterRandom random(seed, 1, static_cast<std::uint64_t>(i + 5000) << 32 | (j + 5000));
      const double x = (i + random.uniform()) * side, y = (j + random.uniform()) * side;
      if (x < west || x >= east || y < south || y >= north) continue;
      const double z = 3.0 * std::sin(0.15 * x) + 2.0 * std::cos(0.2 * y) + 0.02 * random.normal();
      const Vec3d normal =
          normalized(Vec3d{-0.45 * std::cos(0.15 * x), 0.4 * std::sin(0.2 * y), 1.0});
      points.positions.push_back(Vec3d{x, y, z}.cast<float>());
      points.normals.push_back(normal.cast<float>());
      points.quality.push_back(1.0f);
    }
  }
  return points;
}

std::string tile_text(double west, double south, double east, double north) {
  return std::to_string(kWest + west) + "," + std::to_string(kSouth + south) + "," +
         std::to_string(kWest + east) + "," + std::to_string(kSouth + north);
}

const std::vector<float>& property(const Mesh& mesh, const char* name) {
  for (const FloatProperty& p : mesh.float_properties) {
    if (p.name == name) return p.values;
  }
  throw std::runtime_error(std::string("no property ") + name);
}

/// Vertices on the plane x = `x` (metres from the survey's corner), as whole micrometres.
std::set<std::tuple<long long, long long>> on_plane(const Mesh& mesh, double x) {
  std::set<std::tuple<long long, long long>> found;
  for (const Vec3f p : mesh.positions) {
    const Vec3d at = mesh.origin + p.cast<double>();
    if (at.x == kWest + x) found.insert({std::llround(at.y * 1e6), std::llround(at.z * 1e6)});
  }
  return found;
}

class PoissonCommand : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const OrientedPoints& points) const {
    write_ply(folder_ / name, points);
    return file(name);
  }
  /// Solves the tile [west, east] x [0, 24] of the survey with its halo.
  ProcessResult solve(const std::string& name, double west, double east, double density = 8.0,
                      const std::vector<std::string>& more = {}) const {
    const std::string points =
        write(name + ".points.ply", ground(west - 20, -20, east + 20, 44, density));
    std::vector<std::string> words{
        "solve",    points, "-o", file(name + ".field"), "--tile", tile_text(west, 0, east, 24),
        "--halo-m", "20"};
    words.insert(words.end(), more.begin(), more.end());
    return poisson(words);
  }
  ProcessResult extract(const std::string& name, const std::vector<std::string>& bands,
                        const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{
        "extract",  file(name + ".field"),      "-o",         file(name + ".ply"),
        "--points", file(name + ".points.ply"), "--overwrite"};
    if (!bands.empty()) words.push_back("--neighbours");
    for (const std::string& band : bands) words.push_back(file(band + ".band"));
    words.insert(words.end(), more.begin(), more.end());
    return poisson(words);
  }
  test::TemporaryFolder folder_;
};

TEST_F(PoissonCommand, MeshMakesAManifoldWithSupportNearTheGround) {
  const std::string points = write("p.ply", ground(0, 0, 40, 30, 12));
  const ProcessResult run =
      poisson({"mesh", points, "-o", file("m.ply"), "--report", file("r.json")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Mesh mesh = read_ply_mesh(file("m.ply"));
  EXPECT_EQ(mesh.crs_text, "EPSG:2056+5728");
  const TopologyReport topology = check_topology(mesh.triangles, mesh.positions.size(), 2);
  EXPECT_TRUE(topology.is_manifold());
  EXPECT_EQ(topology.isolated_vertices, 0u);
  const std::vector<float>& support = property(mesh, "support");
  const std::vector<float>& density = property(mesh, "density");
  double squares = 0.0, mean_density = 0.0;
  std::size_t inside = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d p = mesh.origin + mesh.positions[v].cast<double>() - Vec3d{kWest, kSouth, 1000.0};
    if (p.x < 3 || p.x > 37 || p.y < 3 || p.y > 27) continue;
    const double off = p.z - 3.0 * std::sin(0.15 * p.x) - 2.0 * std::cos(0.2 * p.y);
    squares += off * off;
    mean_density += density[v];
    EXPECT_LT(support[v], 0.6f);
    ++inside;
  }
  ASSERT_GT(inside, 2000u);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(inside)), 0.02);
  EXPECT_NEAR(mean_density / static_cast<double>(inside), 12.0, 1.5);
  const nlohmann::json report = test::read_json(file("r.json"));
  EXPECT_EQ(report["tool"], "cornice-poisson");
  EXPECT_EQ(report["counts"]["triangles"], mesh.triangles.size());
  EXPECT_GT(report["quality"]["levels"].size(), 2u);
}

TEST_F(PoissonCommand, NeighboursMeetBitForBitWhateverTheOrderOfTheirBands) {
  // Borders that are no whole steps: both tiles take the same lattice plane.
  ASSERT_EQ(solve("a", 0, 20.1).exit_code, 0);
  ASSERT_EQ(solve("b", 20.1, 41.7, 8.0, {"--threads", "1"}).exit_code, 0);
  ASSERT_EQ(solve("c", 41.7, 60, 2.0).exit_code, 0);
  ASSERT_EQ(extract("a", {"b", "c"}).exit_code, 0);
  ASSERT_EQ(extract("b", {"c", "a", "b"}).exit_code, 0);
  ASSERT_EQ(extract("c", {"a", "b"}).exit_code, 0);
  const Mesh a = read_ply_mesh(file("a.ply")), b = read_ply_mesh(file("b.ply")),
             c = read_ply_mesh(file("c.ply"));
  EXPECT_GT(on_plane(a, 20.0).size(), 40u);
  EXPECT_EQ(on_plane(a, 20.0), on_plane(b, 20.0));
  EXPECT_GT(on_plane(b, 41.5).size(), 40u);
  EXPECT_EQ(on_plane(b, 41.5), on_plane(c, 41.5));
  const std::string first = test::read_text(file("b.ply"));
  ASSERT_EQ(extract("b", {"a", "c"}, {"--threads", "1"}).exit_code, 0);
  EXPECT_EQ(test::read_text(file("b.ply")), first);
}

TEST_F(PoissonCommand, TheNumberOfThreadsChangesNoByteOfFieldAndBand) {
  ASSERT_EQ(solve("one", 0, 20, 8.0, {"--threads", "1"}).exit_code, 0);
  ASSERT_EQ(solve("two", 0, 20, 8.0, {"--threads", "2"}).exit_code, 0);
  EXPECT_EQ(test::read_text(file("one.field")), test::read_text(file("two.field")));
  EXPECT_EQ(test::read_text(file("one.band")), test::read_text(file("two.band")));
}

TEST_F(PoissonCommand, AListOfTilesDecidesAsBandsOnTheCommandLineDo) {
  ASSERT_EQ(solve("a", 0, 20).exit_code, 0);
  ASSERT_EQ(solve("b", 20, 40).exit_code, 0);
  ASSERT_EQ(extract("a", {"b"}).exit_code, 0);
  const std::string direct = test::read_text(file("a.ply"));
  std::ofstream(file("tiles.txt")) << "a.band\n\nb.band\n";
  ASSERT_EQ(extract("a", {}, {"--tiles", file("tiles.txt")}).exit_code, 0);
  EXPECT_EQ(test::read_text(file("a.ply")), direct);
  std::ofstream(file("tiles.txt"), std::ios::app) << "missing.band\n";
  const ProcessResult run = extract("a", {}, {"--tiles", file("tiles.txt")});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("missing.band"), std::string::npos);
}

TEST_F(PoissonCommand, WithoutNeighboursTheSurfaceEndsAtTheTileOrBeyondAsAsked) {
  ASSERT_EQ(solve("a", 0, 20).exit_code, 0);
  ASSERT_EQ(extract("a", {}).exit_code, 0);
  const auto west = [&] {
    double least = std::numeric_limits<double>::infinity();
    const Mesh mesh = read_ply_mesh(file("a.ply"));
    for (const Vec3f p : mesh.positions) least = std::min(least, mesh.origin.x + p.x);
    return least;
  };
  EXPECT_EQ(west(), kWest);
  ASSERT_EQ(extract("a", {}, {"--margin-m", "10"}).exit_code, 0);
  EXPECT_EQ(west(), kWest - 10.0);
}

TEST_F(PoissonCommand, WrongUseAndDamagedFilesAreOneLineEach) {
  ASSERT_EQ(solve("a", 0, 20).exit_code, 0);
  ASSERT_EQ(solve("b", 20, 40).exit_code, 0);
  const auto refused = [&](const ProcessResult& run, int code, const std::string& part) {
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("cornice-poisson: error: "), std::string::npos) << run.err;
    EXPECT_EQ(test::line_count(run.err.substr(run.err.find("error: "))), 1u) << run.err;
  };
  refused(poisson({}), 2, "ACTION");
  refused(poisson({"melt"}), 2, "solve");
  refused(extract("a", {"b"}, {"--margin-m", "3"}), 2, "--margin-m");
  refused(poisson({"solve", file("a.points.ply"), "-o", file("x.field"), "--tile", "1,2,3"}), 2,
          "--tile");
  refused(poisson({"solve", file("a.points.ply"), "-o", file("x.field"), "--tile", "9,9,3,3"}), 2,
          "--tile");
  refused(poisson({"solve", file("a.points.ply"), "-o", file("x.field"), "--tile", "0,0,50,50"}), 3,
          "no points in the tile");
  refused(poisson({"solve", file("a.points.ply"), "-o", file("a.field")}), 2, "a.field");
  refused(poisson({"extract", file("a.band"), "-o", file("x.ply")}), 3, "border band");
  std::string bytes = test::read_text(file("b.band"));
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(file("b.band"), std::ios::binary) << bytes;
  refused(extract("a", {"b"}), 3, "b.band");
  EXPECT_FALSE(fs::exists(file("a.ply")));
}

TEST_F(PoissonCommand, DegenerateInputIsAnErrorOrASurfaceButNeverACrash) {
  OrientedPoints none;
  none.origin = {kWest, kSouth, 0};
  OrientedPoints one = none, three = none, zero = ground(0, 0, 10, 10, 4), far = zero, heap = none,
                 opposite = zero;
  one.positions = {{1, 1, 1}}, one.normals = {{0, 0, 1}};
  three.positions = {{1, 1, 1}, {5, 1, 1.2f}, {2, 4, 1.5f}};
  three.normals.assign(3, {0, 0, 1});
  zero.normals.assign(zero.positions.size(), {0, 0, 0});
  far.positions.push_back({1000, 1000, 900}), far.normals.push_back({0, 0, 1});
  far.quality.push_back(1);
  heap.positions.assign(20'000, {3.25f, 4.5f, 2.0f}), heap.normals.assign(20'000, {0, 0, 1});
  for (std::size_t p = 0; p < opposite.positions.size(); p += 2) {
    opposite.normals[p] = opposite.normals[p] * -1.0f;
  }
  const std::vector<std::tuple<std::string, OrientedPoints, bool>> cases{
      {"none", none, false}, {"one", one, true},   {"three", three, true},
      {"zero", zero, false}, {"heap", heap, true}, {"opposite", opposite, true}};
  for (const auto& [name, points, must_work] : cases) {
    const ProcessResult run =
        poisson({"mesh", write(name + ".ply", points), "-o", file(name + ".mesh.ply")});
    if (must_work) {
      EXPECT_EQ(run.exit_code, 0) << name << ": " << run.err;
      const Mesh mesh = read_ply_mesh(file(name + ".mesh.ply"));
      EXPECT_TRUE(check_topology(mesh.triangles, mesh.positions.size(), 1).is_manifold()) << name;
    } else {
      EXPECT_EQ(run.exit_code, 3) << name << ": " << run.err;
    }
  }
  // Points far away are outside the tile and its halo, however far.
  far.positions.push_back({1e30f, 5, 5}), far.normals.push_back({0, 0, 1});
  far.quality.push_back(1);
  const ProcessResult run = poisson({"mesh", write("far.ply", far), "-o", file("far.mesh.ply"),
                                     "--tile", tile_text(0, 0, 10, 10)});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("outside tile and halo 2"), std::string::npos) << run.err;
  // Without --tile they would be the tile's corner.
  const ProcessResult boundless = poisson({"mesh", file("far.ply"), "-o", file("no tile.ply")});
  EXPECT_EQ(boundless.exit_code, 3);
  EXPECT_NE(boundless.err.find(file("far.ply") + ": has a point 1000000"), std::string::npos)
      << boundless.err;
  EXPECT_NE(boundless.err.find("give the tile with --tile"), std::string::npos) << boundless.err;
}

TEST_F(PoissonCommand, NormalsThatAreNoNumbersAreRefusedOrLeftOut) {
  const std::string path = write("p.ply", ground(0, 0, 10, 10, 4));
  std::string bytes = test::read_text(path);
  const float nan = std::nanf("");
  constexpr std::size_t kRecord = 28;  // position, normal, quality
  const std::size_t first = bytes.find("end_header") + 11;
  for (std::size_t at = first + 12; at + 4 <= bytes.size(); at += 5 * kRecord) {
    std::memcpy(bytes.data() + at, &nan, sizeof(nan));
  }
  std::ofstream(path, std::ios::binary) << bytes;
  const ProcessResult run = poisson({"mesh", path, "-o", file("m.ply")});
  EXPECT_TRUE(run.exit_code == 3 || run.err.find("not finite 8") != std::string::npos) << run.err;
}

}  // namespace
}  // namespace cornice
