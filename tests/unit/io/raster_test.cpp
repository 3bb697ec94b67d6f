// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/raster.h"

#include <gdal.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/foreign_tiff.h"
#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using test::ForeignTiff;
using test::read_text;
using test::TemporaryFolder;
using test::write_text;
using testing::ElementsAre;
using testing::HasSubstr;

Raster some_raster(int width, int height, std::uint64_t seed) {
  Raster raster;
  raster.width = width;
  raster.height = height;
  raster.west = 2600000.0;
  raster.north = 1200000.5;
  raster.step = 0.5;
  raster.crs = crs_from_text("EPSG:2056+5728");
  CounterRandom random(seed, 0, 0);
  for (int i = 0; i < width * height; ++i) {
    const bool hole = random.bits() % 10 == 0;
    raster.values.push_back(hole ? raster.no_data : static_cast<float>(1000.0 + random.normal()));
  }
  return raster;
}

std::string problem_of(const fs::path& path) {
  try {
    read_raster(path);
  } catch (const InputError& error) {
    EXPECT_EQ(error.subject(), path.string());
    return error.problem();
  }
  return "accepted";
}

TEST(Cog, KeepsValuesGridNoDataAndCrs) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {530, 600}}) {
    const Raster raster = some_raster(width, height, 5);
    write_cog(folder / "a.tif", raster);
    const Raster read = read_raster(folder / "a.tif");
    EXPECT_EQ(read.width, width);
    EXPECT_EQ(read.height, height);
    EXPECT_EQ(read.west, raster.west);
    EXPECT_EQ(read.north, raster.north);
    EXPECT_EQ(read.step, raster.step);
    EXPECT_EQ(read.no_data, raster.no_data);
    EXPECT_TRUE(read.values == raster.values);
    EXPECT_EQ(read.crs.text(), "EPSG:2056+5728");
  }
  EXPECT_THAT(folder.entries(), ElementsAre("a.tif"));
}

TEST(Cog, IsTiledHasOverviewsAndSaysThatItIsOne) {
  const TemporaryFolder folder;
  write_cog(folder / "a.tif", some_raster(700, 530, 6));
  GDALAllRegister();
  GDALDatasetH dataset = GDALOpen((folder / "a.tif").c_str(), GA_ReadOnly);
  ASSERT_NE(dataset, nullptr);
  GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
  int tile_width = 0;
  int tile_height = 0;
  GDALGetBlockSize(band, &tile_width, &tile_height);
  EXPECT_EQ(tile_width, 512);
  EXPECT_EQ(tile_height, 512);
  EXPECT_GE(GDALGetOverviewCount(band), 1);
  EXPECT_STREQ(GDALGetMetadataItem(dataset, "LAYOUT", "IMAGE_STRUCTURE"), "COG");
  EXPECT_STREQ(GDALGetMetadataItem(dataset, "COMPRESSION", "IMAGE_STRUCTURE"), "DEFLATE");
  GDALClose(dataset);
}

TEST(Cog, IsTheSameBytesAgain) {
  const TemporaryFolder folder;
  const Raster raster = some_raster(300, 300, 7);
  write_cog(folder / "a.tif", raster);
  write_cog(folder / "b.tif", raster);
  EXPECT_EQ(read_text(folder / "a.tif"), read_text(folder / "b.tif"));
}

TEST(Cog, TellsOfAFullDiskAndLeavesNothing) {
  const TemporaryFolder folder;
  const Raster raster = some_raster(400, 400, 9);
  const auto outcome =
      test::on_full_disk(folder.path(), [&] { write_cog(folder / "a.tif", raster); });
  if (!outcome) GTEST_SKIP() << "this machine does not let a test mount a small disk";
  EXPECT_THAT(*outcome, testing::StartsWith((folder / "a.tif").string() + ": cannot be written: "));
  EXPECT_THAT(*outcome, testing::Not(HasSubstr("|")));
  EXPECT_THAT(*outcome, testing::Not(HasSubstr("\n")));
}

TEST(Cog, RefusesShapesThatAreNone) {
  const TemporaryFolder folder;
  Raster raster = some_raster(4, 4, 1);
  raster.values.pop_back();
  EXPECT_THROW(write_cog(folder / "a.tif", raster), std::invalid_argument);
  EXPECT_THROW(write_cog(folder / "a.tif", Raster{}), std::invalid_argument);
  raster = some_raster(4, 4, 1);
  raster.step = 0.0;
  EXPECT_THROW(write_cog(folder / "a.tif", raster), std::invalid_argument);
}

TEST(ReadRaster, TakesAsciiGridsOfEitherCorner) {
  const TemporaryFolder folder;
  write_text(folder / "a.asc",
             "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 5\nNODATA_value -9999\n"
             "1 2 3\n4 -9999 6\n");
  const Raster raster = read_raster(folder / "a.asc");
  EXPECT_EQ(raster.west, 100.0);
  EXPECT_EQ(raster.north, 210.0);
  EXPECT_EQ(raster.step, 5.0);
  EXPECT_THAT(raster.values, ElementsAre(1.f, 2.f, 3.f, 4.f, raster.no_data, 6.f));
  EXPECT_TRUE(raster.crs.empty());
  write_text(folder / "b.asc",
             "ncols 1\nnrows 1\nxllcenter 100\nyllcenter 200\ncellsize 5\nNODATA_value -9999\n7\n");
  EXPECT_EQ(read_raster(folder / "b.asc").west, 97.5);
  EXPECT_EQ(read_raster(folder / "b.asc").north, 202.5);
}

TEST(ReadRaster, TakesTheCrsOfAProductNameWhereTheFileHasNone) {
  const TemporaryFolder folder;
  const fs::path path = folder / "swissalti3d_2019_2636-1184_2_2056_5728.tif";
  ForeignTiff(path, 2, 2, GDT_Float32).fill({1, 2, 3, 4});
  EXPECT_EQ(read_raster(path).crs.text(), "EPSG:2056+5728");
}

TEST(ReadRaster, PutsPixelIsPointGridsWhereTheirPointsAre) {
  const TemporaryFolder folder;
  {
    ForeignTiff tiff(folder / "a.tif", 2, 1, GDT_Float32);
    GDALSetMetadataItem(tiff.dataset(), "AREA_OR_POINT", "Point", nullptr);
    tiff.transform({99.5, 1.0, 0.0, 50.5, 0.0, -1.0});
    tiff.fill({1, 2});
  }
  // The file's tie point is now the first pixel's centre, (100, 50).
  const Raster raster = read_raster(folder / "a.tif");
  EXPECT_EQ(raster.west, 99.5);
  EXPECT_EQ(raster.north, 50.5);
}

TEST(ReadRaster, TurnsRowsThatRunNorthwards) {
  const TemporaryFolder folder;
  {
    ForeignTiff tiff(folder / "a.tif", 2, 3, GDT_Float32);
    tiff.transform({10.0, 2.0, 0.0, 20.0, 0.0, 2.0});
    tiff.fill({1, 2, 3, 4, 5, 6});
  }
  const Raster raster = read_raster(folder / "a.tif");
  EXPECT_EQ(raster.north, 26.0);
  EXPECT_THAT(raster.values, ElementsAre(5.f, 6.f, 3.f, 4.f, 1.f, 2.f));
}

TEST(ReadRaster, KnowsNoDataOfEveryKind) {
  const TemporaryFolder folder;
  {
    ForeignTiff tiff(folder / "a.tif", 4, 1, GDT_Float32);
    GDALSetRasterNoDataValue(tiff.band(), 9999.0);
    tiff.fill({1.0, 9999.0, std::numeric_limits<double>::quiet_NaN(),
               std::numeric_limits<double>::infinity()});
  }
  Raster raster = read_raster(folder / "a.tif");
  EXPECT_EQ(raster.no_data, 9999.0f);
  EXPECT_THAT(raster.values, ElementsAre(1.f, 9999.f, 9999.f, 9999.f));
  {
    ForeignTiff tiff(folder / "b.tif", 3, 1, GDT_Float32);
    GDALSetRasterNoDataValue(tiff.band(), std::numeric_limits<double>::quiet_NaN());
    tiff.fill({1.0, std::numeric_limits<double>::quiet_NaN(), -9998.0});
  }
  raster = read_raster(folder / "b.tif");
  EXPECT_THAT(raster.values, ElementsAre(1.f, raster.no_data, -9998.f));
  {
    // -3.4e38 as text is not the float that the pixels hold.
    ForeignTiff tiff(folder / "c.tif", 2, 1, GDT_Float32);
    GDALSetRasterNoDataValue(tiff.band(), -3.4028234663852886e+38);
    tiff.fill({1.0, static_cast<double>(-std::numeric_limits<float>::max())});
  }
  raster = read_raster(folder / "c.tif");
  EXPECT_EQ(raster.values[1], raster.no_data);
}

TEST(ReadRaster, AppliesScaleAndOffsetOfWholeNumbers) {
  const TemporaryFolder folder;
  {
    ForeignTiff tiff(folder / "a.tif", 3, 1, GDT_Int16);
    GDALSetRasterNoDataValue(tiff.band(), -32768.0);
    GDALSetRasterScale(tiff.band(), 0.1);
    GDALSetRasterOffset(tiff.band(), 1000.0);
    tiff.fill({-100, 0, -32768});
  }
  const Raster raster = read_raster(folder / "a.tif");
  EXPECT_FLOAT_EQ(raster.values[0], 990.0f);
  EXPECT_FLOAT_EQ(raster.values[1], 1000.0f);
  EXPECT_EQ(raster.values[2], raster.no_data);
}

TEST(ReadRaster, RefusesGridsItCannotHoldAndSaysWhatToDo) {
  const TemporaryFolder folder;
  const auto problem = [&](std::array<double, 6> transform) {
    ForeignTiff(folder / "a.tif", 100, 100, GDT_Byte).transform(transform);
    return problem_of(folder / "a.tif");
  };
  EXPECT_THAT(problem({0.0, 1.0, 0.2, 0.0, 0.2, -1.0}), HasSubstr("rotated or sheared; make it"));
  EXPECT_THAT(problem({0.0, 1.0, 0.1, 0.0, 0.0, -1.0}), HasSubstr("rotated or sheared"));
  EXPECT_THAT(problem({0.0, 1.0, 0.0, 0.0, 0.0, -2.0}),
              HasSubstr("pixels are 1.000000 by 2.000000"));
  EXPECT_THAT(problem({0.0, 1.0, 0.0, 0.0, 0.0, -1.001}), HasSubstr("square"));
  EXPECT_THAT(problem({0.0, -1.0, 0.0, 0.0, 0.0, -1.0}), HasSubstr("from west to east"));
  EXPECT_EQ(problem({0.0, 1.0, 0.0, 0.0, 0.0, -1.00000001}), "accepted");
}

TEST(ReadRaster, RefusesWhatIsNoRasterWithoutChatterOnStderr) {
  const TemporaryFolder folder;
  write_text(folder / "text.tif", "not a picture at all");
  write_text(folder / "empty.tif", "");
  testing::internal::CaptureStderr();
  EXPECT_THAT(problem_of(folder / "absent.tif"), HasSubstr("No such file"));
  EXPECT_THAT(problem_of(folder.path()), HasSubstr("is a folder"));
  EXPECT_THAT(problem_of(folder / "text.tif"), HasSubstr("is no GeoTIFF or ASCII grid"));
  EXPECT_THAT(problem_of(folder / "empty.tif"), HasSubstr("is no GeoTIFF or ASCII grid"));
  write_cog(folder / "whole.tif", some_raster(300, 300, 8));
  const std::string whole = read_text(folder / "whole.tif");
  write_text(folder / "cut.tif", whole.substr(0, whole.size() / 2));
  EXPECT_NE(problem_of(folder / "cut.tif"), "accepted");
  { const ForeignTiff tiff(folder / "nowhere.tif", 2, 2, GDT_Float32); }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ReadRaster, ReadsRealElevationModels) {
  const fs::path folder = fs::path(CORNICE_TEST_DATA) / "dem";
  if (!fs::is_directory(folder)) {
    GTEST_SKIP() << "the folder of real data, " << folder << ", is not there";
  }
  int read = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".tif" && extension != ".asc") continue;
    SCOPED_TRACE(entry.path().string());
    const Raster raster = read_raster(entry.path());
    float lowest = std::numeric_limits<float>::max();
    float highest = std::numeric_limits<float>::lowest();
    for (const float value : raster.values) {
      if (value == raster.no_data) continue;
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    }
    EXPECT_GT(highest, lowest);
    EXPECT_GT(lowest, -500.0f);
    EXPECT_LT(highest, 9000.0f);
    ++read;
  }
  EXPECT_GT(read, 0);
}

}  // namespace
}  // namespace cornice
