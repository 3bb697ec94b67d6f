// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/error.h"
#include "core/io/las.h"
#include "core/io/ply.h"
#include "core/io/raster.h"
#include "stages/compare/compare.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace cornice::compare {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;

constexpr std::uint64_t kCache = std::uint64_t{1} << 30;
constexpr double kEast = 2600000.0, kNorth = 1200000.0;

double ground(double x, double y) { return 500.0 + 3.0 * std::sin(0.1 * x) + 0.2 * y; }

Mesh ground_mesh(double x, double y, int cells, double step, double lift = 0.0) {
  Mesh mesh = test::height_mesh(
      x, y, cells, step, [&](double px, double py) { return ground(px, py) - 500.0 + lift; });
  mesh.origin = {kEast, kNorth, 500.0};
  mesh.crs_text = "EPSG:2056+5728";
  return mesh;
}

Raster ground_dem(double x, double y, int pixels, double step) {
  Raster raster;
  raster.width = raster.height = pixels;
  raster.west = kEast + x;
  raster.north = kNorth + y + pixels * step;
  raster.step = step;
  raster.crs = crs_from_text("EPSG:2056+5728");
  for (int row = 0; row < pixels; ++row) {
    for (int col = 0; col < pixels; ++col) {
      raster.values.push_back(
          static_cast<float>(ground(x + (col + 0.5) * step, y + (pixels - row - 0.5) * step)));
    }
  }
  return raster;
}

void write_points(const std::filesystem::path& path, double lift, std::uint8_t classification,
                  const std::string& crs = "EPSG:2056+5728") {
  LasWriteOptions options;
  options.offset = {kEast, kNorth, 0.0};
  options.scale = {0.001, 0.001, 0.001};
  options.crs = crs_from_text(crs);
  PointCloud points;
  points.origin = {kEast, kNorth, 500.0};
  for (int i = 0; i < 60 * 60; ++i) {
    const double x = 0.5 + i % 60, y = 0.5 + i / 60;
    points.positions.push_back(Vec3d{x, y, ground(x, y) - 500.0 + lift}.cast<float>());
    points.classification.push_back(classification);
  }
  LasWriter writer(path, options);
  writer.write(points);
  writer.close();
}

Result compare_files(const std::filesystem::path& a, const std::filesystem::path& b,
                     const Options& options = {}, std::uint64_t cache = kCache) {
  const auto source_a = open_source(a, options, cache), source_b = open_source(b, options, cache);
  return compare(
      *source_a, *source_b, options, {}, [](const MeasuredPart&) {}, no_progress());
}

/// What it says of the pair, and where.
template <class E>
std::string problem_of(const std::filesystem::path& a, const std::filesystem::path& b) {
  try {
    compare_files(a, b);
  } catch (const E& error) {
    return error.what();
  }
  return "nothing";
}

class Sources : public testing::Test {
 protected:
  TemporaryFolder folder_;
};

TEST_F(Sources, OfEveryKindAgreeOnOneGround) {
  write_ply(folder_ / "mesh.ply", ground_mesh(0, 0, 120, 0.5, 0.25));
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 60, 1.0));
  write_points(folder_ / "points.laz", 0.5, 2);
  const Result dem_mesh = compare_files(folder_ / "dem.tif", folder_ / "mesh.ply");
  EXPECT_NEAR(dem_mesh.vertical.all().summary().mean, 0.25, 0.002);
  for (const Direction& d : dem_mesh.directions) {
    const Summary s = d.statistics.all().summary();
    // Along the normal of a slope, not upwards.
    EXPECT_NEAR(s.mean, 0.25 * 0.96, 0.02);
    EXPECT_LT(s.standard_deviation, 0.02);
    EXPECT_NEAR(static_cast<double>(s.count), 4.0 * dem_mesh.sides[0].area_m2, 800.0);
  }
  const Result mesh_cloud = compare_files(folder_ / "mesh.ply", folder_ / "points.laz");
  EXPECT_NEAR(mesh_cloud.vertical.all().summary().mean, 0.25, 0.01);
  EXPECT_NEAR(mesh_cloud.directions[1].statistics.all().summary().mean, 0.25 * 0.96, 0.02);
  EXPECT_FALSE(mesh_cloud.directions[0].has_sign);
  write_points(folder_ / "other.laz", 0.9, 2);
  const Result clouds = compare_files(folder_ / "points.laz", folder_ / "other.laz");
  ASSERT_TRUE(clouds.m3c2.has_value());
}

TEST_F(Sources, GiveTheSameWhetherInOneTileOrInFour) {
  write_ply(folder_ / "whole.ply", ground_mesh(0, 0, 80, 1.0, 0.1));
  std::filesystem::create_directory(folder_ / "tiles");
  for (int k = 0; k < 4; ++k) {
    Mesh tile = ground_mesh(40.0 * (k % 2), 40.0 * (k / 2), 40, 1.0, 0.1);
    // Origins of their own, as tiles have.
    const Vec3d move{40.0 * (k % 2), 40.0 * (k / 2), 7.0};
    tile.origin += move;
    for (Vec3f& p : tile.positions) p -= move.cast<float>();
    write_ply(folder_ / ("tiles/t" + std::to_string(k) + ".ply"), tile);
  }
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 160, 0.5));
  std::filesystem::create_directory(folder_ / "dems");
  for (int k = 0; k < 4; ++k) {
    write_cog(folder_ / ("dems/d" + std::to_string(k) + ".tif"),
              ground_dem(40.0 * (k % 2), 40.0 * (k / 2), 80, 0.5));
  }
  const Result one = compare_files(folder_ / "dem.tif", folder_ / "whole.ply");
  // A cache that holds nothing: every tile is read again and again.
  const Result four = compare_files(folder_ / "dems", folder_ / "tiles", {}, 1);
  EXPECT_EQ(four.sides[1].facts.files.size(), 4u);
  EXPECT_EQ(one.vertical.all().count(), four.vertical.all().count());
  EXPECT_NEAR(one.vertical.all().summary().rms, four.vertical.all().summary().rms, 1e-5);
  for (const std::size_t d : {0u, 1u}) {
    const Summary a = one.directions[d].statistics.all().summary();
    const Summary b = four.directions[d].statistics.all().summary();
    EXPECT_NEAR(a.mean, b.mean, 5e-4);
    EXPECT_NEAR(a.rms, b.rms, 5e-4);
    EXPECT_NEAR(static_cast<double>(a.count), static_cast<double>(b.count), 300.0);
    // Borders between tiles are no edges: no more is missing than around the whole.
    EXPECT_NEAR(static_cast<double>(a.missing), static_cast<double>(b.missing), 60.0);
  }
}

TEST_F(Sources, KeepThePixelsOfADemOnItsOwnGrid) {
  write_cog(folder_ / "a.tif", ground_dem(0, 0, 50, 2.0));
  write_ply(folder_ / "b.ply", ground_mesh(0, 0, 100, 1.0, 1.0));
  const Result result = compare_files(folder_ / "a.tif", folder_ / "b.ply");
  EXPECT_DOUBLE_EQ(result.difference.step, 2.0);
  EXPECT_DOUBLE_EQ(result.difference.west, kEast);
  // Vertices of the mesh lie on the pixels' centres: nothing is interpolated on either side.
  for (const float value : result.difference.values) EXPECT_NEAR(value, 1.0f, 1e-4f);
}

TEST_F(Sources, HolesAreMissingAndNeverDistances) {
  Raster dem = ground_dem(0, 0, 80, 1.0);
  for (int row = 20; row < 60; ++row) {
    for (int col = 20; col < 60; ++col) dem.at(col, row) = dem.no_data;
  }
  write_cog(folder_ / "holed.tif", dem);
  write_ply(folder_ / "mesh.ply", ground_mesh(0, 0, 160, 0.5));
  const Result result = compare_files(folder_ / "holed.tif", folder_ / "mesh.ply");
  const Summary s = result.directions[1].statistics.all().summary();
  EXPECT_LT(s.highest, 0.05);
  EXPECT_GT(s.lowest, -0.05);
  EXPECT_NEAR(static_cast<double>(s.missing), 4.0 * 41 * 41 * 1.04, 500.0);
  EXPECT_EQ(result.vertical.all().missing(), 1600u);
}

TEST_F(Sources, ReadOnlyTheClassesAskedForAndNeverNoise) {
  std::filesystem::create_directory(folder_ / "points");
  write_points(folder_ / "points/ground.laz", 0.0, 2);
  write_points(folder_ / "points/trees.laz", 9.0, 5);
  write_points(folder_ / "points/noise.laz", 90.0, 7);
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 60, 1.0));
  Options all, ground_only;
  ground_only.classes = {2};
  EXPECT_EQ(compare_files(folder_ / "dem.tif", folder_ / "points", all).sides[1].points_used,
            7200u);
  const Result result = compare_files(folder_ / "dem.tif", folder_ / "points", ground_only);
  EXPECT_EQ(result.sides[1].points_used, 3600u);
  EXPECT_NEAR(result.vertical.all().summary().mean, 0.0, 0.01);
}

TEST_F(Sources, WithAnotherSystemDatumOrUnitAreRefusedPlainly) {
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 40, 1.0));
  Raster other = ground_dem(0, 0, 40, 1.0);
  other.crs = crs_from_text("EPSG:2154");
  write_cog(folder_ / "lambert.tif", other);
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "lambert.tif"),
              HasSubstr("another coordinate system"));
  other.crs = crs_from_text("EPSG:2056+5729");
  write_cog(folder_ / "rh.tif", other);
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "rh.tif"),
              HasSubstr("heights of another datum"));
  write_points(folder_ / "feet.laz", 0.0, 2, "EPSG:2264");
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "feet.laz"), HasSubstr("feet"));
  write_points(folder_ / "degrees.laz", 0.0, 2, "EPSG:4326");
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "degrees.laz"),
              HasSubstr("degrees"));
}

TEST_F(Sources, InFeetUnderAnHonestNameAreFoundByTheirHeights) {
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 40, 1.0));
  Raster feet = ground_dem(0, 0, 40, 1.0);
  for (float& z : feet.values) z *= 3.2808399f;
  write_cog(folder_ / "feet.tif", feet);
  const std::string second = problem_of<InputError>(folder_ / "dem.tif", folder_ / "feet.tif");
  EXPECT_THAT(second, HasSubstr("feet.tif: has heights in feet"));
  EXPECT_THAT(problem_of<InputError>(folder_ / "feet.tif", folder_ / "dem.tif"),
              HasSubstr("feet.tif: has heights in feet"));
}

TEST_F(Sources, ThatAGeoidPartsAreWarnedOf) {
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 40, 1.0));
  Raster ellipsoid = ground_dem(0, 0, 40, 1.0);
  for (float& z : ellipsoid.values) z += 49.5f;
  write_cog(folder_ / "ellipsoid.tif", ellipsoid);
  const Result result = compare_files(folder_ / "dem.tif", folder_ / "ellipsoid.tif");
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_THAT(result.warnings[0], HasSubstr("49.5 m"));
}

TEST_F(Sources, WithNothingToCompareAreRefusedPlainly) {
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 40, 1.0));
  write_cog(folder_ / "far.tif", ground_dem(5000, 0, 40, 1.0));
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "far.tif"),
              HasSubstr("lies elsewhere"));
  Mesh empty = ground_mesh(0, 0, 4, 1.0);
  empty.triangles.clear();
  write_ply(folder_ / "empty.ply", empty);
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "empty.ply"),
              HasSubstr("mesh without triangles"));
  Raster nothing = ground_dem(0, 0, 40, 1.0);
  for (float& z : nothing.values) z = nothing.no_data;
  write_cog(folder_ / "nothing.tif", nothing);
  EXPECT_THAT(problem_of<InputError>(folder_ / "nothing.tif", folder_ / "dem.tif"),
              HasSubstr("nothing.tif: has no height"));
  LasWriteOptions options;
  options.crs = crs_from_text("EPSG:2056+5728");
  LasWriter writer(folder_ / "none.laz", options);
  writer.close();
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "none.laz"),
              HasSubstr("has no points"));
  std::filesystem::create_directory(folder_ / "folder");
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "folder"),
              HasSubstr("holds no mesh, raster or point file"));
}

TEST_F(Sources, OfHostileFilesEndInOneErrorEach) {
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 40, 1.0));
  const std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex ";
  test::write_text(folder_ / "huge.ply",
                   header +
                       "99999999999\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 1\nproperty list uchar int vertex_indices\nend_header\n");
  EXPECT_NE(problem_of<InputError>(folder_ / "dem.tif", folder_ / "huge.ply"), "nothing");
  test::write_text(folder_ / "nan.ply",
                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                   "end_header\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "nan.ply"),
              HasSubstr("nan.ply"));
  test::write_text(folder_ / "text.tif", "this is no picture");
  EXPECT_THAT(problem_of<InputError>(folder_ / "text.tif", folder_ / "dem.tif"),
              HasSubstr("text.tif"));
  test::write_text(folder_ / "cut.laz", "LASF");
  EXPECT_NE(problem_of<InputError>(folder_ / "cut.laz", folder_ / "dem.tif"), "nothing");
  test::write_text(folder_ / "list.txt", "dem.tif\nmissing.tif\n");
  EXPECT_THAT(problem_of<InputError>(folder_ / "list.txt", folder_ / "dem.tif"),
              HasSubstr("missing.tif"));
}

TEST_F(Sources, WithHeightsThatStandForNoDataUntoldAreRefused) {
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 40, 1.0));
  Raster raster = ground_dem(0, 0, 40, 1.0);
  raster.values[300] = -3.4028235e38f;
  write_cog(folder_ / "untold.tif", raster);
  EXPECT_THAT(problem_of<InputError>(folder_ / "dem.tif", folder_ / "untold.tif"),
              HasSubstr("untold.tif: has a height of -3.40282347e+38 m, which no ground has"));
}

TEST_F(Sources, WhoseHeadersSayTheyReachAnywhereAreRefused) {
  write_cog(folder_ / "dem.tif", ground_dem(0, 0, 40, 1.0));
  write_points(folder_ / "points.las", 0.0, 2);
  const std::string whole = test::read_text(folder_ / "points.las");
  const auto problem = [&](double max_x) {
    std::string bytes = whole;
    std::memcpy(bytes.data() + 179, &max_x, sizeof max_x);
    test::write_text(folder_ / "odd.las", bytes);
    return problem_of<InputError>(folder_ / "dem.tif", folder_ / "odd.las");
  };
  EXPECT_THAT(problem(1e300), HasSubstr("odd.las: says it reaches from 2600000"));
  EXPECT_THAT(problem(std::numeric_limits<double>::infinity()), HasSubstr("to inf, 1200"));
  EXPECT_THAT(problem(0.0), HasSubstr("odd.las: has bounds in its header that hold nothing"));
}

TEST_F(Sources, SayWhatTrianglesAnErrorCosts) {
  write_cog(folder_ / "a.tif", ground_dem(0, 0, 20, 4.0));
  write_ply(folder_ / "b.ply", ground_mesh(0, 0, 160, 0.5));
  write_ply(folder_ / "coarse.ply", ground_mesh(0, 0, 10, 8.0));
  write_ply(folder_ / "fine.ply", ground_mesh(0, 0, 40, 2.0));
  const Options options;
  const auto a = open_source(folder_ / "a.tif", options, kCache);
  const auto b = open_source(folder_ / "b.ply", options, kCache);
  Result result = compare(
      *a, *b, options, {}, [](const MeasuredPart&) {}, no_progress());
  EXPECT_FALSE(triangles_for_error_of_a(result).has_value());
  for (const char* name : {"coarse.ply", "fine.ply"}) {
    const auto version = open_source(folder_ / name, options, kCache);
    result.versions.push_back(measure_version(*version, *b, result, options, no_progress()));
  }
  ASSERT_EQ(result.versions.size(), 3u);
  // The error of a chord grows with the square of its length.
  EXPECT_NEAR(result.versions[1].distances.rms / result.versions[2].distances.rms, 16.0, 3.0);
  const auto triangles = triangles_for_error_of_a(result);
  ASSERT_TRUE(triangles.has_value());
  // The DEM has 4 m too: 20 x 20 cells on this ground.
  EXPECT_NEAR(*triangles, 800.0, 160.0);
}

}  // namespace
}  // namespace cornice::compare
