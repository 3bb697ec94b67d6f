// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-dem as it is run: what it writes, and what it refuses and how it says so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/ply.h"
#include "core/io/raster.h"
#include "core/mesh/topology.h"
#include "tests/support/foreign_tiff.h"
#include "tests/support/json_file.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ForeignTiff;
using test::ProcessResult;
using test::read_text;
using test::TemporaryFolder;
using test::write_text;
using testing::HasSubstr;
using testing::MatchesRegex;

constexpr int kDone = 0, kUsage = 2, kBadInput = 3;
const std::array<double, 6> kPlace{2600000.0, 2.0, 0.0, 1200000.0, 0.0, -2.0};

ProcessResult run_dem(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), (fs::path(CORNICE_BIN_DIR) / "cornice-dem").string());
  arguments.push_back("--no-progress");
  return test::run_process(arguments);
}

std::vector<double> slope(int width, int height) {
  std::vector<double> values;
  for (int i = 0; i < width * height; ++i) values.push_back(500.0 + i % width + 2 * (i / width));
  return values;
}

/// A raster of 20 x 10 pixels of two metres, with what `change` does to it.
template <class Change>
fs::path write_tiff(const TemporaryFolder& folder, const std::string& name, GDALDataType type,
                    Change change) {
  ForeignTiff tiff(folder / name, 20, 10, type);
  tiff.transform(kPlace);
  tiff.crs("EPSG:2056");
  change(tiff);
  return folder / name;
}
fs::path write_tiff(const TemporaryFolder& folder, const std::string& name) {
  return write_tiff(folder, name, GDT_Float32, [](ForeignTiff& t) { t.fill(slope(20, 10)); });
}

/// That the program ends with the code and one line on stderr that names the file.
void expect_refused(const std::vector<std::string>& arguments, int code, const std::string& file,
                    const std::string& problem) {
  const ProcessResult run = run_dem(arguments);
  EXPECT_EQ(run.exit_code, code) << run.err;
  EXPECT_THAT(run.err, HasSubstr("cornice-dem: error: " + file));
  // One line, below warnings at most.
  const std::string line = run.err.substr(std::min(run.err.size(), run.err.find("error: ")));
  EXPECT_EQ(test::line_count(line), 1u) << run.err;
  EXPECT_THAT(run.err, HasSubstr(problem));
}

TEST(DemProgram, WritesATileWithItsPlaceSystemAndNormals) {
  const TemporaryFolder folder;
  const fs::path tile = write_tiff(folder, "swissalti3d_2019_2600-1199_2_2056_5728.tif");
  const ProcessResult run = run_dem(
      {tile.string(), "-o", (folder / "out").string(), "--report", (folder / "r").string()});
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const Mesh mesh = read_ply_mesh(folder / "out" / "swissalti3d_2019_2600-1199_2_2056_5728.ply");
  EXPECT_EQ(mesh.crs_text, "EPSG:2056+5728");
  EXPECT_EQ(mesh.positions.size(), 200u);
  EXPECT_EQ(mesh.triangles.size(), 2u * 19u * 9u);
  // Pixel is area: the first vertex is the centre of the north-western pixel.
  const Vec3d first = mesh.origin + mesh.positions[0].cast<double>();
  EXPECT_EQ(first, (Vec3d{2600001.0, 1199999.0, 500.0}));
  // One metre up over two to the east, two down over two to the north.
  const Vec3d normal = normalized(Vec3d{-0.5, 1.0, 1.0});
  EXPECT_LT(norm(mesh.normals[25].cast<double>() - normal), 1e-6);
  const auto report = test::read_json(folder / "r");
  EXPECT_EQ(report["counts"]["triangles"], 342);
  EXPECT_EQ(report["warnings"].size(), 0u);
}

TEST(DemProgram, PutsVerticesOnThePointsWherePixelsArePoints) {
  const TemporaryFolder folder;
  const fs::path tile = write_tiff(folder, "points.tif", GDT_Float32, [](ForeignTiff& t) {
    GDALSetMetadataItem(t.dataset(), "AREA_OR_POINT", "Point", nullptr);
    t.transform({2599999.0, 2.0, 0.0, 1200001.0, 0.0, -2.0});
    t.fill(slope(20, 10));
  });
  ASSERT_EQ(run_dem({tile.string(), "-o", (folder / "out").string()}).exit_code, kDone);
  const Mesh mesh = read_ply_mesh(folder / "out" / "points.ply");
  EXPECT_EQ(mesh.origin + mesh.positions[0].cast<double>(), (Vec3d{2600000.0, 1200000.0, 500.0}));
  // The same by an ASCII grid that gives its centre.
  write_text(folder / "grid.asc",
             "ncols 2\nnrows 2\nxllcenter 2600000\nyllcenter 1200000\ncellsize 1\n1 2\n3 4\n");
  ASSERT_EQ(run_dem({(folder / "grid.asc").string(), "-o", (folder / "asc").string(), "--crs",
                     "EPSG:2056", "--vertical-crs", "EPSG:5728"})
                .exit_code,
            kDone);
  const Mesh grid = read_ply_mesh(folder / "asc" / "grid.ply");
  EXPECT_EQ(grid.crs_text, "EPSG:2056+5728");
  EXPECT_EQ(grid.origin + grid.positions[2].cast<double>(), (Vec3d{2600000.0, 1200000.0, 3.0}));
}

TEST(DemProgram, TakesWholeNumbersAndScaledOnes) {
  const TemporaryFolder folder;
  const fs::path tile = write_tiff(folder, "int.tif", GDT_Int16, [](ForeignTiff& t) {
    GDALSetRasterNoDataValue(t.band(), -32768.0);
    GDALSetRasterScale(t.band(), 0.5);
    std::vector<double> values = slope(20, 10);
    values[0] = -32768.0;
    t.fill(values);
  });
  ASSERT_EQ(run_dem({tile.string(), "-o", (folder / "out").string()}).exit_code, kDone);
  const Mesh mesh = read_ply_mesh(folder / "out" / "int.ply");
  EXPECT_EQ(mesh.positions.size(), 199u);
  EXPECT_EQ(mesh.positions[0].z, 250.5f);
}

TEST(DemProgram, MakesHolesOfEveryKindOfNoData) {
  const TemporaryFolder folder;
  for (const double nothing : {9999.0, -9999.0, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
    const fs::path tile = write_tiff(folder, "holes.tif", GDT_Float32, [&](ForeignTiff& t) {
      if (std::isfinite(nothing)) GDALSetRasterNoDataValue(t.band(), nothing);
      std::vector<double> values = slope(20, 10);
      values[5 * 20 + 7] = nothing;
      t.fill(values);
    });
    ASSERT_EQ(run_dem({tile.string(), "-o", (folder / "out").string(), "--overwrite"}).exit_code,
              0);
    const Mesh mesh = read_ply_mesh(folder / "out" / "holes.ply");
    EXPECT_EQ(mesh.positions.size(), 199u);
    EXPECT_EQ(mesh.triangles.size(), 2u * 19u * 9u - 4u);
  }
}

TEST(DemProgram, RefusesGridsThatAreNotNorthUp) {
  const TemporaryFolder folder;
  const auto with = [&](std::array<double, 6> transform) {
    return write_tiff(folder, "a.tif", GDT_Float32, [&](ForeignTiff& t) {
      t.transform(transform);
      t.fill(slope(20, 10));
    });
  };
  const std::string out = (folder / "out").string();
  const fs::path rotated = with({2600000.0, 1.9, 0.6, 1200000.0, 0.6, -1.9});
  expect_refused({rotated.string(), "-o", out}, kBadInput, rotated.string(),
                 "rotated or sheared; make it north-up first, with gdalwarp");
  const fs::path skewed = with({2600000.0, 2.0, 0.3, 1200000.0, 0.0, -2.0});
  expect_refused({skewed.string(), "-o", out}, kBadInput, skewed.string(), "rotated or sheared");
  const fs::path oblong = with({2600000.0, 2.0, 0.0, 1200000.0, 0.0, -3.0});
  expect_refused({oblong.string(), "-o", out}, kBadInput, oblong.string(), "make them square");
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(DemProgram, RefusesTilesWithoutCrsUntilTold) {
  const TemporaryFolder folder;
  const fs::path tile = folder / "bare.tif";
  {
    ForeignTiff tiff(tile, 20, 10, GDT_Float32);
    tiff.transform(kPlace);
    tiff.fill(slope(20, 10));
  }
  const std::string out = (folder / "out").string();
  expect_refused({tile.string(), "-o", out}, kBadInput, tile.string(),
                 "has no CRS, neither in the file nor by its name; tell it with --crs");
  EXPECT_EQ(run_dem({tile.string(), "-o", out, "--crs", "EPSG:2056+5728"}).exit_code, kDone);
  expect_refused({tile.string(), "-o", out, "--overwrite", "--crs", "EPSG:2056", "--vertical-crs",
                  "EPSG:2154"},
                 kUsage, "--vertical-crs", "names no vertical system");
}

TEST(DemProgram, SaysPlainlyThatFeetAndDegreesAreNoMetres) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const auto with = [&](const std::string& crs, double west, double step, const char* unit) {
    return write_tiff(folder, "a.tif", GDT_Float32, [&](ForeignTiff& t) {
      t.transform({west, step, 0.0, west, 0.0, -step});
      t.crs(crs);
      GDALSetRasterUnitType(t.band(), unit);
      t.fill(slope(20, 10));
    });
  };
  fs::path tile = with("EPSG:2994", 600000.0, 3.0, "");
  expect_refused({tile.string(), "-o", out}, kBadInput, tile.string(),
                 "its pixels are feet or another unit of 0.3048 m");
  tile = with("EPSG:2056", 2600000.0, 2.0, "ft");
  expect_refused({tile.string(), "-o", out}, kBadInput, tile.string(),
                 "its heights are feet or another unit of 0.3048 m, not metres; convert them");
  tile = with("EPSG:26910+6360", 600000.0, 2.0, "");
  expect_refused({tile.string(), "-o", out}, kBadInput, tile.string(), "its heights are feet");
  tile = with("EPSG:4326", 10.0, 0.001, "");
  expect_refused({tile.string(), "-o", out}, kBadInput, tile.string(), "its pixels are degrees");
  tile = with("EPSG:4326", 195000.0, 10.0, "");
  expect_refused({tile.string(), "-o", out}, kBadInput, tile.string(),
                 "its CRS is wrong; tell the true one with --crs");
}

TEST(DemProgram, RefusesTilesWithoutAnyHeight) {
  const TemporaryFolder folder;
  const auto empty = [&](const std::string& name) {
    return write_tiff(folder, name, GDT_Float32, [](ForeignTiff& t) {
      GDALSetRasterNoDataValue(t.band(), -9999.0);
      t.fill(std::vector<double>(200, -9999.0));
    });
  };
  const fs::path tile = empty("empty.tif");
  expect_refused({tile.string(), "-o", (folder / "out").string()}, kBadInput, tile.string(),
                 "none of its pixels has a height");
  // Beside others an empty tile is counted.
  const fs::path full = write_tiff(folder, "full.tif");
  const ProcessResult run =
      run_dem({tile.string(), full.string(), "-o", (folder / "two").string()});
  EXPECT_EQ(run.exit_code, kDone);
  EXPECT_THAT(run.err, HasSubstr("overlap"));
}

TEST(DemProgram, RefusesHeightsThatStandForNoDataUntold) {
  const TemporaryFolder folder;
  const fs::path tile = write_tiff(folder, "a.tif", GDT_Float32, [](ForeignTiff& t) {
    std::vector<double> values = slope(20, 10);
    values[5 * 20 + 7] = -9999.0;
    t.fill(values);
  });
  const std::string out = (folder / "out").string();
  expect_refused({tile.string(), "-o", out}, kBadInput, tile.string(),
                 "has a height of -9999 m at 2600015, 1199989, which no ground has; if it stands "
                 "for no data, say --no-data -9999");
  ASSERT_EQ(run_dem({tile.string(), "-o", out, "--overwrite", "--no-data", "-9999"}).exit_code, 0);
  EXPECT_EQ(read_ply_mesh(folder / "out" / "a.ply").positions.size(), 199u);
}

TEST(DemProgram, RefusesTilesOfDifferentSystemsAndGrids) {
  const TemporaryFolder folder;
  const fs::path a = write_tiff(folder, "a.tif");
  const auto other = [&](const std::string& crs, double west) {
    return write_tiff(folder, "b.tif", GDT_Float32, [&](ForeignTiff& t) {
      t.crs(crs);
      t.transform({west, 2.0, 0.0, 1200000.0, 0.0, -2.0});
      t.fill(slope(20, 10));
    });
  };
  const std::string out = (folder / "out").string();
  fs::path b = other("EPSG:21781", 2600040.0);
  expect_refused({a.string(), b.string(), "-o", out}, kBadInput, b.string(),
                 "is in CH1903 / LV03, but " + a.string() + " is in CH1903+ / LV95");
  b = other("EPSG:2056", 2600040.7);
  expect_refused({a.string(), b.string(), "-o", out}, kBadInput, b.string(),
                 "bring all onto one with --resample 2");
  EXPECT_EQ(run_dem({a.string(), b.string(), "-o", out, "--resample", "2"}).exit_code, kDone);
  const ProcessResult far =
      run_dem({a.string(), other("EPSG:2056", 2700000.0).string(), "-o", out, "--overwrite"});
  EXPECT_EQ(far.exit_code, kDone);
  EXPECT_THAT(far.err, HasSubstr("2 tiles beside no other"));
}

TEST(DemProgram, TwoGridsOfDifferentVerticalDatumsAreRefused) {
  const TemporaryFolder folder;
  const auto tile = [&](const std::string& name, const std::string& crs, double west) {
    return write_tiff(folder, name, GDT_Float32, [&](ForeignTiff& t) {
      t.crs(crs);
      t.transform({west, 2.0, 0.0, 1200000.0, 0.0, -2.0});
      t.fill(slope(20, 10));
    });
  };
  const fs::path a = tile("a.tif", "EPSG:2056+5728", 2600000.0);
  const fs::path b = tile("b.tif", "EPSG:2056+5729", 2600040.0);
  expect_refused({a.string(), b.string(), "-o", (folder / "out").string()}, kBadInput, b.string(),
                 "bring both into one system and datum");
}

/// The file with the value of a tag of its first directory replaced.
std::string patched_tag(std::string tiff, std::uint16_t tag, std::uint32_t value) {
  std::uint32_t directory = 0;
  std::uint16_t entries = 0;
  std::memcpy(&directory, tiff.data() + 4, 4);
  std::memcpy(&entries, tiff.data() + directory, 2);
  for (std::size_t i = 0; i < entries; ++i) {
    char* entry = tiff.data() + directory + 2 + 12 * i;
    if (std::memcmp(entry, &tag, 2) != 0) continue;
    const std::uint16_t is_long = 4;
    std::memcpy(entry + 2, &is_long, 2);
    std::memcpy(entry + 8, &value, 4);
  }
  return tiff;
}

TEST(DemProgram, RefusesDamagedFiles) {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const std::string whole = read_text(write_tiff(folder, "whole.tif"));
  const std::string name = (folder / "a.tif").string();
  write_text(name, patched_tag(patched_tag(whole, 256, 0x7ffffff0u), 257, 0x7ffffff0u));
  expect_refused({name, "-o", out}, kBadInput, name, "");
  // The heights themselves are cut off.
  Raster raster;
  raster.width = raster.height = 600;
  raster.west = 2600000.0;
  raster.north = 1200000.0;
  raster.crs = crs_from_text("EPSG:2056+5728");
  for (int i = 0; i < 360000; ++i)
    raster.values.push_back(static_cast<float>(i % 600 * 797 % 1000));
  write_cog(folder / "cog.tif", raster);
  const std::string cog = read_text(folder / "cog.tif");
  write_text(name, cog.substr(0, cog.size() * 6 / 10));
  expect_refused({name, "-o", out}, kBadInput, name, "");
  write_text(name, "not a raster");
  expect_refused({name, "-o", out}, kBadInput, name, "is no GeoTIFF or ASCII grid");
  expect_refused({(folder / "absent.tif").string(), "-o", out}, kBadInput,
                 (folder / "absent.tif").string(), "No such file");
  EXPECT_TRUE(!fs::exists(folder / "out") || fs::is_empty(folder / "out"));
}

TEST(DemProgram, KeepsToItsMemoryAndSplitsLargeTiles) {
  const TemporaryFolder folder;
  // As a large raster is stored: tiles of 256 pixels, those without data left out.
  constexpr int kSide = 6000;
  {
    GDALAllRegister();
    char* options[] = {const_cast<char*>("TILED=YES"), const_cast<char*>("SPARSE_OK=TRUE"),
                       const_cast<char*>("COMPRESS=DEFLATE"), nullptr};
    GDALDatasetH tiff = GDALCreate(GDALGetDriverByName("GTiff"), (folder / "large.tif").c_str(),
                                   kSide, kSide, 1, GDT_Float32, options);
    std::array<double, 6> place{2600000.0, 0.5, 0.0, 1200000.0, 0.0, -0.5};
    GDALSetGeoTransform(tiff, place.data());
    GDALRasterBandH band = GDALGetRasterBand(tiff, 1);
    GDALSetRasterNoDataValue(band, -9999.0);
    std::vector<float> rows(256 * 400, 800.0f);
    EXPECT_EQ(GDALRasterIO(band, GF_Write, 2900, 2900, 400, 256, rows.data(), 400, 256, GDT_Float32,
                           0, 0),
              CE_None);
    GDALClose(tiff);
  }
  const ProcessResult run =
      run_dem({(folder / "large.tif").string(), "-o", (folder / "out").string(), "--crs",
               "EPSG:2056+5728", "--memory", "0.3", "--tile-pixels", "1500", "--threads", "2",
               "--report", (folder / "r").string()});
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.err, HasSubstr("6000 x 6000 pixels become 16 meshes of at most 1500 pixels"));
  const auto report = test::read_json(folder / "r");
  EXPECT_EQ(report["counts"]["meshes"], 4);
  EXPECT_EQ(report["counts"]["triangles"], 2 * 399 * 255);
  EXPECT_LT(report["peak_memory_bytes"], 0.3 * 1024 * 1024 * 1024);
  // Less than one piece needs: said before anything is written.
  const ProcessResult little =
      run_dem({(folder / "large.tif").string(), "-o", (folder / "no").string(), "--crs",
               "EPSG:2056", "--memory", "0.25", "--tile-pixels", "4000"});
  EXPECT_EQ(little.exit_code, 1);
  EXPECT_THAT(little.err, HasSubstr("lower --tile-pixels"));
}

TEST(DemProgram, MeshesOneTileOfManyAsItMeshesAll) {
  const TemporaryFolder folder;
  const fs::path a = write_tiff(folder, "a.tif");
  const fs::path b = write_tiff(folder, "b.tif", GDT_Float32, [](ForeignTiff& t) {
    t.transform({2600040.0, 2.0, 0.0, 1200000.0, 0.0, -2.0});
    t.fill(slope(20, 10));
  });
  ASSERT_EQ(run_dem({a.string(), b.string(), "-o", (folder / "all").string()}).exit_code, kDone);
  ASSERT_EQ(run_dem({b.string(), a.string(), "--only", a.string(), "-o", (folder / "one").string()})
                .exit_code,
            kDone);
  EXPECT_EQ(read_text(folder / "one" / "a.ply"), read_text(folder / "all" / "a.ply"));
  EXPECT_FALSE(fs::exists(folder / "one" / "b.ply"));
  EXPECT_EQ(read_ply_mesh(folder / "all" / "a.ply").triangles.size(), 2u * 20u * 9u);
}

TEST(DemProgram, WritesObjAndGlb) {
  const TemporaryFolder folder;
  const fs::path tile = write_tiff(folder, "a.tif");
  for (const std::string format : {"obj", "glb"}) {
    ASSERT_EQ(
        run_dem({tile.string(), "-o", (folder / format).string(), "--format", format}).exit_code,
        kDone);
    EXPECT_GT(fs::file_size(folder / format / ("a." + format)), 1000u);
  }
  const std::string obj = read_text(folder / "obj" / "a.obj").substr(0, 200);
  EXPECT_THAT(obj, HasSubstr("# cornice origin 2600020 1199990 0"));
  EXPECT_THAT(obj, HasSubstr("\nv -19.0000 9.0000 500.0000\n"));
}

TEST(DemProgram, MakesARasterOfItsMeshes) {
  const TemporaryFolder folder;
  const fs::path tile = write_tiff(folder, "swissalti3d_2019_2600-1199_2_2056_5728.tif");
  const fs::path mesh = folder / "out" / "swissalti3d_2019_2600-1199_2_2056_5728.ply";
  const std::string layers = (folder / "layers.tif").string();
  ASSERT_EQ(run_dem({tile.string(), "-o", (folder / "out").string()}).exit_code, kDone);
  ASSERT_EQ(
      run_dem({"--from-mesh", mesh.string(), "-o", layers, "--like", tile.string()}).exit_code,
      kDone);
  const Raster was = read_raster(tile), is = read_raster(layers);
  EXPECT_EQ(is.values, was.values);
  EXPECT_EQ(is.west, was.west);
  EXPECT_EQ(is.crs.text(), "EPSG:2056+5728");
  ASSERT_EQ(run_dem({"--from-mesh", mesh.string(), "-o", layers, "--step", "0.5", "--overwrite"})
                .exit_code,
            kDone);
  // The outermost centres are one and a half metres from the tile's edge.
  EXPECT_EQ(read_raster(layers).west, 2600001.0);
  EXPECT_EQ(read_raster(layers).width, 76);
  expect_refused({"--from-mesh", mesh.string(), "-o", layers, "--overwrite"}, kUsage, "--step",
                 "give either");
  expect_refused({tile.string(), "--from-mesh", mesh.string(), "-o", layers, "--overwrite"}, kUsage,
                 "--from-mesh", "leave the TILES away");
  const fs::path foreign = write_tiff(folder, "utm.tif", GDT_Float32, [](ForeignTiff& t) {
    t.crs("EPSG:32632");
    t.fill(slope(20, 10));
  });
  expect_refused(
      {"--from-mesh", mesh.string(), "-o", layers, "--like", foreign.string(), "--overwrite"},
      kBadInput, foreign.string(), "name a raster of their system");
}

TEST(DemProgram, RefusesTilesWhoseMeshesWouldHaveOneName) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "b");
  const fs::path a = write_tiff(folder, "a.tif");
  fs::copy(a, folder / "b" / "a.tif");
  expect_refused({a.string(), (folder / "b" / "a.tif").string(), "-o", (folder / "out").string()},
                 kUsage, (folder / "b" / "a.tif").string(), "every tile needs a name of its own");
}

TEST(DemProgram, MeshesRealTilesThatMeet) {
  const fs::path data = fs::path(CORNICE_TEST_DATA);
  const fs::path folder_of_tiles = data / "ign_adjacent_1km";
  if (!fs::is_directory(folder_of_tiles)) {
    GTEST_SKIP() << "the folder of real data, " << folder_of_tiles << ", is not there";
  }
  const TemporaryFolder folder;
  std::vector<std::string> arguments;
  for (const auto& entry : fs::directory_iterator(folder_of_tiles)) {
    if (entry.path().extension() == ".tif") arguments.push_back(entry.path().string());
  }
  ASSERT_EQ(arguments.size(), 2u);
  arguments.insert(arguments.end(), {"-o", (folder / "out").string()});
  const ProcessResult run = run_dem(arguments);
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const ProcessResult check = test::run_process(
      {(fs::path(CORNICE_BIN_DIR) / "cornice-stitch").string(),
       (folder / "out" / "test_mns_hydro_2023_0299_6802_LA93_IGN69_5m.ply").string(),
       (folder / "out" / "test_mns_hydro_2023_0300_6802_LA93_IGN69_5m.ply").string(), "--check",
       "--no-progress"});
  EXPECT_EQ(check.exit_code, kDone) << check.err;
  EXPECT_THAT(check.err, HasSubstr("shared edges 199"));
  const fs::path wrong = data / "dem" / "avaframe_fluchthorn.tif";
  expect_refused({wrong.string(), "-o", (folder / "no").string()}, kBadInput, wrong.string(),
                 "its CRS is wrong; tell the true one with --crs");
  EXPECT_EQ(run_dem({wrong.string(), "-o", (folder / "yes").string(), "--crs", "EPSG:31254+5195"})
                .exit_code,
            kDone);
}

}  // namespace
}  // namespace cornice
