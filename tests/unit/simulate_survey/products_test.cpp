// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/products.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geo/product_name.h"
#include "stages/simulate/survey_options.h"

namespace cornice::simulate {
namespace {

TileGrid kilometre_grid(SurveyProduct product) {
  const Vec3d corner = default_corner(product);
  return {corner.x, corner.y, 1000.0, 2, 2};
}

TEST(Products, SwissNamesGiveTheSouthWestCorner) {
  const TileGrid grid = kilometre_grid(SurveyProduct::kSwissSurface3d);
  EXPECT_EQ(
      tile_name(SurveyProduct::kSwissSurface3d, TileContainer::kZippedLas, grid, 0, 2019, "a"),
      "swisssurface3d_2019_2746-1234_2056_5728.las.zip");
  EXPECT_EQ(tile_name(SurveyProduct::kSwissSurface3d, TileContainer::kCopc, grid, 3, 2025, "a"),
            "swisssurface3d_2025_2747-1235_2056_5728.copc.laz");
}

TEST(Products, LidarHdNamesGiveTheNorthWestCorner) {
  const TileGrid grid = kilometre_grid(SurveyProduct::kLidarHd);
  EXPECT_EQ(tile_name(SurveyProduct::kLidarHd, TileContainer::kCopc, grid, 0, 2021, "a"),
            "LHD_FXX_0998_6537_PTS_O_LAMB93_IGN69.copc.laz");
}

TEST(Products, EveryTileAndDemNameSaysWhereItsTileIs) {
  for (const SurveyProduct product : {SurveyProduct::kSwissSurface3d, SurveyProduct::kLidarHd}) {
    const TileGrid grid = kilometre_grid(product);
    for (int tile = 0; tile < grid.count(); ++tile) {
      for (const TileContainer container : {TileContainer::kLas, TileContainer::kLaz,
                                            TileContainer::kZippedLas, TileContainer::kCopc}) {
        const auto name =
            parse_product_name(tile_name(product, container, grid, tile, 2021, "alp"));
        ASSERT_TRUE(name.has_value());
        EXPECT_EQ(name->tile, grid.tile(tile));
        EXPECT_EQ(name->crs_text, crs_text(product));
      }
      for (const double step : {0.5, 2.0}) {
        const std::string text = dem_name(product, grid, tile, 2021, step, "alp");
        const auto name = parse_product_name(text);
        ASSERT_TRUE(name.has_value()) << text;
        EXPECT_EQ(name->tile, grid.tile(tile)) << text;
      }
    }
  }
}

TEST(Products, NamesOfSmallTilesAreOfNoProduct) {
  for (const SurveyProduct product : {SurveyProduct::kSwissSurface3d, SurveyProduct::kLidarHd}) {
    TileGrid grid = kilometre_grid(product);
    grid.tile_m = 500.0;
    EXPECT_FALSE(has_product_names(grid));
    for (const TileContainer container : {TileContainer::kLaz, TileContainer::kCopc})
      for (int tile = 0; tile < grid.count(); ++tile)
        EXPECT_FALSE(parse_product_name(tile_name(product, container, grid, tile, 2021, "pass")));
    EXPECT_FALSE(parse_product_name(dem_name(product, grid, 1, 2021, 0.5, "pass")));
    EXPECT_NE(tile_name(product, TileContainer::kLaz, grid, 0, 2021, "pass"),
              tile_name(product, TileContainer::kLaz, grid, 1, 2021, "pass"));
  }
  TileGrid shifted = kilometre_grid(SurveyProduct::kLidarHd);
  shifted.west += 500.0;
  EXPECT_FALSE(has_product_names(shifted));
}

TEST(Products, HeadersAreThoseOfTheRealTiles) {
  const Box2d tile{2746000.0, 1234000.0, 2747000.0, 1235000.0};
  const LasWriteOptions swiss =
      write_options(SurveyProduct::kSwissSurface3d, TileContainer::kLaz, tile, 2019);
  EXPECT_EQ(swiss.version_minor, 2);
  EXPECT_EQ(swiss.point_format, 1);
  EXPECT_TRUE(swiss.crs.empty());
  EXPECT_EQ(swiss.offset, (Vec3d{2746000.0, 1234000.0, 0.0}));
  const LasWriteOptions french =
      write_options(SurveyProduct::kLidarHd, TileContainer::kLaz, tile, 2021);
  EXPECT_EQ(french.version_minor, 4);
  EXPECT_EQ(french.point_format, 6);
  EXPECT_EQ(french.crs.text(), "EPSG:2154+5720");
  EXPECT_EQ(french.offset, (Vec3d{}));
  EXPECT_EQ(french.scale, (Vec3d{0.01, 0.01, 0.01}));
}

TEST(Products, VegetationOfLidarHdIsToldApartByHeight) {
  const auto classes = [](double height) {
    return class_of(SurveyProduct::kLidarHd, SurfaceId::kVegetation, height);
  };
  EXPECT_EQ(classes(0.3), 3);
  EXPECT_EQ(classes(1.0), 4);
  EXPECT_EQ(classes(9.0), 5);
  EXPECT_EQ(class_of(SurveyProduct::kSwissSurface3d, SurfaceId::kVegetation, 9.0), 3);
  EXPECT_EQ(class_of(SurveyProduct::kSwissSurface3d, SurfaceId::kHouse, 0.0), 6);
  EXPECT_EQ(class_of(SurveyProduct::kLidarHd, SurfaceId::kWater, 0.0), 9);
  EXPECT_EQ(class_of(SurveyProduct::kLidarHd, SurfaceId::kOverhang, 0.0), 2);
}

TEST(TileGrid, APointOnABorderBelongsToOneTileTheEasternOrNorthern) {
  const TileGrid grid{1000.0, 2000.0, 100.0, 2, 2};
  const auto find = [&](double x, double y) { return grid.find(to_steps(x), to_steps(y)); };
  EXPECT_EQ(find(1000.0, 2000.0), 0);
  EXPECT_EQ(find(1099.99, 2050.0), 0);
  EXPECT_EQ(find(1100.0, 2050.0), 1);
  EXPECT_EQ(find(1050.0, 2100.0), 2);
  EXPECT_EQ(find(1100.0, 2100.0), 3);
  EXPECT_EQ(find(1199.99, 2199.99), 3);
  EXPECT_EQ(find(1200.0, 2050.0), std::nullopt);
  EXPECT_EQ(find(1050.0, 2200.0), std::nullopt);
  EXPECT_EQ(find(999.99, 2050.0), std::nullopt);
}

TEST(SurveyOptions, BadTilesSizesAndCornersAreRefused) {
  const auto refused = [](auto change) {
    SurveyOptions options;
    change(options);
    try {
      check(options);
    } catch (const UsageError& error) {
      return error.subject();
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused([](SurveyOptions&) {}), "accepted");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.tiles = "3"; }), "--tiles");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.tiles = "0x2"; }), "--tiles");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.tiles = "2x2m"; }), "--tiles");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.tile_m = 62.5; }), "--tile-size");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.corner = {1.0}; }), "--corner");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.corner = {1.5, 2.0}; }), "--corner");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.defects = {"sloppy"}; }), "--defects");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.truth_mesh_step_m = 0.01; }), "--truth-mesh-step");
  EXPECT_EQ(refused([](SurveyOptions& o) { o.truth_dem_step_m = 0.3; }), "--truth-dem-step");
  EXPECT_EQ(refused([](SurveyOptions& o) {
              o.tile_m = 50.0;
              o.truth_dem_step_m = 60.0;
            }),
            "--truth-dem-step");
  EXPECT_EQ(refused([](SurveyOptions& o) {
              o.scanner.channels = 2;
              o.channel_tag = ChannelTag::kScannerChannel;
            }),
            "--channel-tag");
  EXPECT_EQ(refused([](SurveyOptions& o) {
              o.container = TileContainer::kCopc;
              o.defects = {"unordered"};
            }),
            "--defects");
}

TEST(SurveyOptions, FlightsStartInTheYearAskedForInAdjustedStandardTime) {
  // 2021-06-15 08:00 is 1307779200 s after the start of GPS time.
  EXPECT_EQ(start_time_s(2021), 307779200.0);
  EXPECT_NEAR(start_time_s(2022) - start_time_s(2021), 365.0 * 86400.0, 1e-9);
}

}  // namespace
}  // namespace cornice::simulate
