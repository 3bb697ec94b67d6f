// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/product_name.h"

#include <gtest/gtest.h>

#include <string>

namespace cornice {
namespace {

struct Expected {
  const char* name;
  Product product;
  int year;
  Box2d tile;
  const char* crs_text;
};

class KnownName : public testing::TestWithParam<Expected> {};

TEST_P(KnownName, IsTakenApart) {
  const Expected& expected = GetParam();
  const auto name = parse_product_name(expected.name);
  ASSERT_TRUE(name) << expected.name;
  EXPECT_EQ(name->product, expected.product) << expected.name;
  EXPECT_EQ(name->year, expected.year) << expected.name;
  EXPECT_EQ(name->tile, expected.tile) << expected.name;
  EXPECT_EQ(name->crs_text, expected.crs_text) << expected.name;
}

constexpr Box2d square(double x, double y) { return {x, y, x + 1000.0, y + 1000.0}; }
constexpr const char* kSwiss = "EPSG:2056+5728";
constexpr const char* kFrench = "EPSG:2154+5720";

INSTANTIATE_TEST_SUITE_P(
    Swiss, KnownName,
    testing::Values(Expected{"swisssurface3d_2019_2746-1234_2056_5728.las.zip",
                             Product::kSwissSurface3d, 2019, square(2746e3, 1234e3), kSwiss},
                    Expected{"swisssurface3d_2025_2505-1119_2056_5728.copc.laz",
                             Product::kSwissSurface3d, 2025, square(2505e3, 1119e3), kSwiss},
                    Expected{"swissSURFACE3D_2019_2746-1234_2056_5728.LAS",
                             Product::kSwissSurface3d, 2019, square(2746e3, 1234e3), kSwiss},
                    Expected{"swissalti3d_2019_2636-1184_0.5_2056_5728.tif", Product::kSwissAlti3d,
                             2019, square(2636e3, 1184e3), kSwiss},
                    Expected{"swissalti3d_2022_2636-1184_2_2056_5728.xyz.zip",
                             Product::kSwissAlti3d, 2022, square(2636e3, 1184e3), kSwiss},
                    Expected{"swisssurface3d-raster_2019_2636-1184_0.5_2056_5728.tif",
                             Product::kSwissSurface3dRaster, 2019, square(2636e3, 1184e3),
                             kSwiss}));

// The corner is the north-west one: 6868 is the tile from 6867 km to 6868 km.
INSTANTIATE_TEST_SUITE_P(
    LidarHd, KnownName,
    testing::Values(Expected{"LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.copc.laz",
                             Product::kLidarHdPoints, 0, square(657e3, 6867e3), kFrench},
                    Expected{"LHD_FXX_0657_6868_PTS_C_LAMB93_IGN69.copc.laz",
                             Product::kLidarHdPoints, 0, square(657e3, 6867e3), kFrench},
                    Expected{"LHD_FXX_0657_6868_PTS_LAMB93_IGN69.laz", Product::kLidarHdPoints, 0,
                             square(657e3, 6867e3), kFrench},
                    Expected{"LHD-FXX-0657-6868-PTS-O-LAMB93-IGN69.copc.laz",
                             Product::kLidarHdPoints, 0, square(657e3, 6867e3), kFrench},
                    Expected{"LHD_FXX_1176_6120_PTS_O_LAMB93_IGN78.copc.laz",
                             Product::kLidarHdPoints, 0, square(1176e3, 6119e3), "EPSG:2154+5721"},
                    Expected{"LHD_REU_0377_7656_PTS_O_RGR92UTM40S_REUN89.copc.laz",
                             Product::kLidarHdPoints, 0, square(377e3, 7655e3), "EPSG:2975+5758"},
                    Expected{"LHD_REU_0377_7656_PTS_O.copc.laz", Product::kLidarHdPoints, 0,
                             square(377e3, 7655e3), "EPSG:2975"},
                    Expected{"LHD_GLP_0650_1790_PTS_O_RGAF09UTM20_GUAD88.copc.laz",
                             Product::kLidarHdPoints, 0, square(650e3, 1789e3), "EPSG:5490+5757"},
                    Expected{"LHD_MYT_0520_8590_PTS_O_RGM04UTM38S_MAYO53.copc.laz",
                             Product::kLidarHdPoints, 0, square(520e3, 8589e3), "EPSG:4471+5793"},
                    Expected{"LHD_FXX_0957_6218_MNT_O_0M50_LAMB93_IGN69.tif",
                             Product::kLidarHdRaster, 0, square(957e3, 6217e3), kFrench},
                    Expected{"LHD_FXX_0957_6218_MNS_O_0M50_LAMB93_IGN69", Product::kLidarHdRaster,
                             0, square(957e3, 6217e3), kFrench},
                    Expected{"Semis_2021_0382_6565_LA93_IGN69.laz", Product::kLidarHdPoints, 2021,
                             square(382e3, 6564e3), kFrench},
                    Expected{"test_semis_2023_0299_6802_LA93_IGN69.laz", Product::kLidarHdPoints,
                             2023, square(299e3, 6801e3), kFrench},
                    Expected{"Semis_2022_0906_6665_LA93_IGN69_ok.laz", Product::kLidarHdPoints,
                             2022, square(906e3, 6664e3), kFrench},
                    Expected{"anything_2021_0382_6565_LA93_IGN69_cropped.laz",
                             Product::kLidarHdPoints, 2021, square(382e3, 6564e3), kFrench},
                    Expected{"test_data_0436_6384_LA93_IGN69_single_point.laz",
                             Product::kLidarHdPoints, 0, square(436e3, 6383e3), kFrench},
                    Expected{"test_mns_hydro_2023_0299_6802_LA93_IGN69_5m.tif",
                             Product::kLidarHdRaster, 2023, square(299e3, 6801e3), kFrench},
                    // Sample tiles of 50 m: the CRS is right, a square kilometre would be wrong.
                    Expected{"test_data_77055_627760_LA93_IGN69.laz", Product::kLidarHdPoints, 0,
                             Box2d{}, kFrench},
                    Expected{"test_data_77050_627755_LA93_IGN69.copc.laz", Product::kLidarHdPoints,
                             0, Box2d{}, kFrench}));

TEST(ProductName, IsNothingForNamesOfNoProduct) {
  const std::string hostile[] = {"",
                                 ".",
                                 "_",
                                 "-",
                                 "lhd",
                                 "LHD_",
                                 "swiss",
                                 "swisssurface3d",
                                 "swisssurface3d_",
                                 "swisssurface3d____.las",
                                 "swisssurface3d_2019_2746-1234_2056_5728",
                                 "swisssurface3d_2019_2746-1234_2056_5728.las.zip.exe",
                                 "swisssurface3d_2019_2746-1234_2056_5729.las",
                                 "swisssurface3d_2019_2746-1234_2154_5728.las",
                                 "swisssurface3d_2019_9999-9999_2056_5728.las",
                                 "swisssurface3d_2019_02746-1234_2056_5728.las",
                                 "swisssurface3d_20x9_2746-1234_2056_5728.las",
                                 "swisssurface3d_2019_2746_1234_2056_5728.las",
                                 "swissalti3d_2019_2636-1184_2056_5728.tif",
                                 "swisssurface3d_2019_2746-1234_2056_5728.tif",
                                 "LHD_FXX_9999_9999_PTS_O_LAMB93_IGN69.copc.laz",
                                 "LHD_FXX_657_6868_PTS_O_LAMB93_IGN69.copc.laz",
                                 "LHD_XXX_0657_6868_PTS_O.copc.laz",
                                 "LHD_FXX_PTS_LAMB93.laz",
                                 "LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.copc.laz.partial",
                                 "LAMB93_IGN69",
                                 "0657_6868.laz",
                                 "870000_6618000.subset.50mx100m.las",
                                 "test_noepsg_043500_629205_IGN69.laz",
                                 "2021_0382_6565.laz",
                                 "a/LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.copc.laz",
                                 "corse.laz",
                                 std::string("swisssurface3d_2019_2746-1234_2056_5728\0.las", 44),
                                 std::string(100000, '_'),
                                 std::string(100000, '9') + "_LA93_IGN69x.la",
                                 "\xff\xfe_0657_6868_LA93\xff.laz"};
  for (const std::string& name : hostile) {
    EXPECT_FALSE(parse_product_name(name)) << name.substr(0, 80);
  }
}

TEST(ProductName, ReadsBackEveryNameItMakes) {
  for (int east : {2485, 2746, 2833}) {
    for (int north : {1075, 1234, 1295}) {
      for (const char* extension : {".las.zip", ".copc.laz"}) {
        const auto name = parse_product_name(swisssurface3d_name(2019, east, north, extension));
        ASSERT_TRUE(name);
        EXPECT_EQ(name->product, Product::kSwissSurface3d);
        EXPECT_EQ(name->tile, square(east * 1e3, north * 1e3));
      }
    }
  }
  for (int east : {99, 657, 1242}) {
    for (int north : {6050, 6868, 7110}) {
      const auto name = parse_product_name(lidarhd_name(east, north, ".copc.laz"));
      ASSERT_TRUE(name);
      EXPECT_EQ(name->product, Product::kLidarHdPoints);
      EXPECT_EQ(name->tile, square(east * 1e3, (north - 1) * 1e3));
    }
  }
}

TEST(ProductName, MakesTheNamesOfTheProducers) {
  EXPECT_EQ(swisssurface3d_name(2019, 2746, 1234, ".las.zip"),
            "swisssurface3d_2019_2746-1234_2056_5728.las.zip");
  EXPECT_EQ(lidarhd_name(657, 6868, ".copc.laz"), "LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.copc.laz");
}

}  // namespace
}  // namespace cornice
