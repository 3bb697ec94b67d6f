// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/drape/raster_pyramid.h"

#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/drape/made_raster.h"

namespace cornice::viewer {
namespace {

using test::MadeRaster;
using test::make_tiff;

const std::string kScene = "EPSG:2056+5728";

/// A texel of a tile, (0, 0) the first that is no border.
std::array<std::uint8_t, 4> photo_texel(const RasterTile& tile, int column, int row) {
  std::array<std::uint8_t, 4> texel{};
  std::memcpy(texel.data(), tile.bytes.data() + ((row + 1) * kTileSide + column + 1) * 4, 4);
  return texel;
}
std::array<float, 2> value_texel(const RasterTile& tile, int column, int row) {
  std::array<float, 2> texel{};
  std::memcpy(texel.data(), tile.bytes.data() + ((row + 1) * kTileSide + column + 1) * 8, 8);
  return texel;
}

double of_place(int b, int column, int row) {
  return b == 0   ? (column * 7 + row) % 251
         : b == 1 ? (column + row * 5) % 241
                  : (column ^ row) & 255;
}

class Pyramid : public testing::Test {
 protected:
  std::filesystem::path made(const std::string& name, const MadeRaster& raster,
                             const std::function<double(int, int, int)>& value) {
    make_tiff(folder_ / name, raster, value);
    return folder_ / name;
  }
  test::TemporaryFolder folder_;
};

TEST_F(Pyramid, HasAsManyLevelsAsItTakesToBecomeOneTile) {
  EXPECT_EQ(make_grid(1, 1, 0, 0, 1, 1).levels, 1);
  EXPECT_EQ(make_grid(256, 200, 0, 0, 1, 1).levels, 1);
  EXPECT_EQ(make_grid(257, 3, 0, 0, 1, 1).levels, 2);
  EXPECT_EQ(make_grid(512, 512, 0, 0, 1, 1).levels, 2);
  EXPECT_EQ(make_grid(40000, 30000, 0, 0, 1, 1).levels, 9);
  for (const int size : {1, 255, 256, 257, 511, 512, 513, 1000, 70001}) {
    const PyramidGrid grid = make_grid(size, 3, 0, 0, 1, 1);
    EXPECT_EQ(grid.columns(grid.levels - 1), 1) << size;
    EXPECT_EQ(grid.rows(grid.levels - 1), 1) << size;
    EXPECT_EQ(grid.columns(0), (size + 255) / 256) << size;
  }
}

TEST_F(Pyramid, GivesThePixelsThemselvesAtItsFinestLevelWithTheirNeighboursAround) {
  const auto file = made("photo.tif", {600, 300, 3}, of_place);
  RasterPyramid pyramid({file}, RasterKind::kPhoto, kScene);
  EXPECT_EQ(pyramid.grid().west, 2600000.0);
  EXPECT_EQ(pyramid.grid().north, 1200000.0);
  const auto expect_pixel = [&](const RasterTile& tile, int column, int row) {
    const int x = std::clamp(tile.key.column * 256 + column, 0, 599);
    const int y = std::clamp(tile.key.row * 256 + row, 0, 299);
    const auto texel = photo_texel(tile, column, row);
    for (int b = 0; b < 3; ++b)
      ASSERT_EQ(texel[std::size_t(b)], of_place(b, x, y)) << x << " " << y << " " << b;
    ASSERT_EQ(texel[3], 255);
  };
  for (int row = 0; row < pyramid.grid().rows(0); ++row)
    for (int column = 0; column < pyramid.grid().columns(0); ++column) {
      const RasterTile tile = pyramid.read({0, column, row});
      for (const int x : {-1, 0, 17, 87, 88, 255, 256})
        for (const int y : {-1, 0, 43, 44, 200, 255, 256}) expect_pixel(tile, x, y);
    }
}

TEST_F(Pyramid, AveragesPixelsInCoarserLevels) {
  const auto file = made("photo.tif", {512, 512, 3}, [](int b, int column, int row) {
    return 10 * b + (column % 2) * 40 + (row % 2) * 80 + (column >= 256 ? 20 : 0);
  });
  RasterPyramid pyramid({file}, RasterKind::kPhoto, kScene);
  const RasterTile tile = pyramid.read({1, 0, 0});
  EXPECT_EQ(photo_texel(tile, 3, 200), (std::array<std::uint8_t, 4>{60, 70, 80, 255}));
  EXPECT_EQ(photo_texel(tile, 130, 9), (std::array<std::uint8_t, 4>{80, 90, 100, 255}));
}

TEST_F(Pyramid, SaysWhereNothingIsAndMixesNothingInFromThere) {
  MadeRaster raster{64, 64, 4};
  const auto file = made("photo.tif", raster, [](int b, int column, int) {
    const bool is_there = column < 32;
    return b == 3 ? (is_there ? 255 : 0) : is_there ? 200 : 3;
  });
  RasterPyramid pyramid({file}, RasterKind::kPhoto, kScene);
  const RasterTile tile = pyramid.read({0, 0, 0});
  EXPECT_EQ(photo_texel(tile, 31, 5), (std::array<std::uint8_t, 4>{200, 200, 200, 255}));
  EXPECT_EQ(photo_texel(tile, 32, 5), (std::array<std::uint8_t, 4>{200, 200, 200, 0}));
  EXPECT_EQ(photo_texel(tile, 40, 5)[3], 0);
}

TEST_F(Pyramid, GivesValuesWithTheirHoles) {
  MadeRaster raster{300, 300, 1, GDT_Float32};
  raster.has_no_data = true;
  raster.no_data = -9999.0;
  const auto file = made("values.tif", raster, [](int, int column, int row) {
    return row >= 100 && row < 140 ? -9999.0 : 0.25 * column - 20.0;
  });
  RasterPyramid pyramid({file}, RasterKind::kValues, kScene);
  const RasterTile tile = pyramid.read({0, 0, 0});
  EXPECT_EQ(value_texel(tile, 8, 50), (std::array<float, 2>{-18.0f, 1.0f}));
  EXPECT_EQ(value_texel(tile, 8, 120), (std::array<float, 2>{0.0f, 0.0f}));
  EXPECT_NEAR(value_texel(tile, 8, 100)[0], -18.0, 1e-5) << "spread from the row above";
  EXPECT_EQ(value_texel(tile, 8, 100)[1], 0.0f);
  // Differences run from -20 to 54.75.
  EXPECT_EQ(value_range(pyramid.read({1, 0, 0})), 100.0);
}

TEST_F(Pyramid, BringsAnotherReferenceSystemIntoThatOfTheScene) {
  // Values are the northing in UTM zone 32, on a grid around 2600500 1199500 in LV95.
  const auto to_utm = [](double e, double n) {
    OGRSpatialReferenceH from = OSRNewSpatialReference(nullptr);
    OGRSpatialReferenceH to = OSRNewSpatialReference(nullptr);
    OSRImportFromEPSG(from, 2056);
    OSRImportFromEPSG(to, 32632);
    for (OGRSpatialReferenceH srs : {from, to})
      OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
    OGRCoordinateTransformationH way = OCTNewCoordinateTransformation(from, to);
    OCTTransform(way, 1, &e, &n, nullptr);
    OCTDestroyCoordinateTransformation(way);
    OSRDestroySpatialReference(from);
    OSRDestroySpatialReference(to);
    return std::array<double, 2>{e, n};
  };
  const auto centre = to_utm(2600500.0, 1199500.0);
  MadeRaster raster{400, 400, 1, GDT_Float32};
  raster.crs = "EPSG:32632";
  const double west = std::round(centre[0]) - 200.0, north = std::round(centre[1]) + 200.0;
  raster.transform = {west, 1.0, 0.0, north, 0.0, -1.0};
  const auto file = made("utm.tif", raster, [](int, int, int row) { return 200.0 - (row + 0.5); });
  RasterPyramid pyramid({file}, RasterKind::kValues, kScene);
  const PyramidGrid& grid = pyramid.grid();
  ASSERT_LT(grid.west, 2600450.0);
  ASSERT_GT(grid.east(), 2600550.0);
  const int column = int((2600450.0 - grid.west) / grid.texel_x);
  const int row = int((grid.north - 1199550.0) / grid.texel_y);
  const RasterTile tile = pyramid.read({0, column / 256, row / 256});
  const auto there =
      to_utm(grid.west + (column + 0.5) * grid.texel_x, grid.north - (row + 0.5) * grid.texel_y);
  const auto texel = value_texel(tile, column % 256, row % 256);
  EXPECT_EQ(texel[1], 1.0f);
  EXPECT_NEAR(texel[0], there[1] - (north - 200.0), 0.2);
}

TEST_F(Pyramid, TurnsARasterThatIsNotNorthUp) {
  MadeRaster raster{40, 40, 3};
  raster.transform = {2600000.0, 1.0, 0.0, 1199960.0, 0.0, 1.0};  // rows from the south
  const auto file =
      made("up.tif", raster, [](int, int, int row) { return row < 20 ? 50.0 : 150.0; });
  RasterPyramid pyramid({file}, RasterKind::kPhoto, kScene);
  const RasterTile tile = pyramid.read({0, 0, 0});
  EXPECT_EQ(pyramid.grid().north, 1200000.0);
  EXPECT_EQ(photo_texel(tile, 10, 2)[0], 150) << "in the north";
  EXPECT_EQ(photo_texel(tile, 10, 37)[0], 50);
}

TEST_F(Pyramid, PutsTheTilesOfAPhotographTogether) {
  MadeRaster left{200, 100, 3}, right{200, 100, 3};
  right.transform[0] += 200.0;
  const auto west = made("west.tif", left, [](int, int column, int) { return column / 2; });
  const auto east = made("east.tif", right, [](int, int column, int) { return 100 + column / 2; });
  RasterPyramid pyramid({east, west}, RasterKind::kPhoto, kScene);
  EXPECT_EQ(pyramid.grid().width, 400);
  const RasterTile tile = pyramid.read({0, 0, 0});
  EXPECT_EQ(photo_texel(tile, 198, 50)[0], 99);
  EXPECT_EQ(photo_texel(tile, 200, 50)[0], 100);
  EXPECT_EQ(photo_texel(pyramid.read({0, 1, 0}), 0, 50)[0], 128);
}

TEST_F(Pyramid, ReadsGreyLikeColours) {
  const auto grey = made("grey.tif", {20, 20, 1}, [](int, int c, int) { return 5 * c; });
  RasterPyramid pyramid({grey}, RasterKind::kPhoto, kScene);
  EXPECT_EQ(photo_texel(pyramid.read({0, 0, 0}), 7, 3),
            (std::array<std::uint8_t, 4>{35, 35, 35, 255}));
}

TEST_F(Pyramid, RefusesWhatItCannotLayOverTheGround) {
  const auto expect_refused = [](const std::filesystem::path& file, RasterKind kind,
                                 const std::string& part) {
    try {
      RasterPyramid pyramid({file}, kind, kScene);
      ADD_FAILURE() << file << " is taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  MadeRaster nowhere{20, 20, 3};
  nowhere.transform.clear();
  expect_refused(made("nowhere.tif", nowhere, of_place), RasterKind::kPhoto, "where it lies");
  expect_refused(made("deep.tif", {20, 20, 3, GDT_UInt16}, of_place), RasterKind::kPhoto,
                 "gdal_translate");
  test::write_text(folder_ / "text.tif", "no raster");
  expect_refused(folder_ / "text.tif", RasterKind::kPhoto, "text.tif");
  expect_refused(folder_ / "missing.tif", RasterKind::kValues, "missing.tif");
}

TEST_F(Pyramid, NamesTheKindOfARaster) {
  EXPECT_EQ(raster_kind(made("a.tif", {8, 8, 3}, of_place)), RasterKind::kPhoto);
  EXPECT_EQ(raster_kind(made("b.tif", {8, 8, 1, GDT_Float32}, of_place)), RasterKind::kValues);
  test::write_text(folder_ / "c.tif", "no raster");
  EXPECT_EQ(raster_kind(folder_ / "c.tif"), std::nullopt);
}

}  // namespace
}  // namespace cornice::viewer
