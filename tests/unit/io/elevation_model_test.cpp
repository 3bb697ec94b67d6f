// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/elevation_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr double kWest = 2600000.0, kSouth = 1200000.0;
const std::string kCrs = "EPSG:2056+5728";
const Box2d kArea{kWest, kSouth, kWest + 100, kSouth + 100};

double slope(double x, double y) { return 500.0 + 0.3 * (x - kWest) - 0.2 * (y - kSouth); }

Raster raster(double west, double south, int pixels, double step,
              const std::function<double(double, double)>& height, const std::string& crs = kCrs) {
  Raster r;
  r.width = r.height = pixels;
  r.west = west;
  r.north = south + pixels * step;
  r.step = step;
  if (!crs.empty()) r.crs = crs_from_text(crs);
  for (int row = 0; row < pixels; ++row) {
    for (int col = 0; col < pixels; ++col) {
      const double z = height(west + (col + 0.5) * step, r.north - (row + 0.5) * step);
      r.values.push_back(std::isnan(z) ? r.no_data : static_cast<float>(z));
    }
  }
  return r;
}

class ElevationModelTest : public testing::Test {
 protected:
  fs::path write(const std::string& name, const Raster& r) const {
    write_cog(folder_ / name, r);
    return folder_ / name;
  }
  std::string problem(const fs::path& path, const std::string& crs = kCrs) const {
    try {
      ElevationModel::read({path}, crs, kArea);
    } catch (const InputError& error) {
      EXPECT_EQ(error.subject(), path.string());
      return error.problem();
    }
    return "accepted";
  }
  test::TemporaryFolder folder_;
};

TEST_F(ElevationModelTest, IsExactOnAPlaneAndSoIsItsNormal) {
  const auto model =
      ElevationModel::read({write("a.tif", raster(kWest, kSouth, 50, 2.0, slope))}, kCrs, kArea);
  const Vec3d normal = normalized(Vec3d{-0.3, 0.2, 1.0});
  for (std::uint64_t i = 0; i < 300; ++i) {
    CounterRandom random(7, 1, i);
    const double x = kWest + random.uniform(1, 99), y = kSouth + random.uniform(1, 99);
    const auto ground = model.at(x, y);
    ASSERT_TRUE(ground);
    EXPECT_NEAR(ground->height_m, slope(x, y), 1e-4);
    EXPECT_LT(norm(ground->normal - normal), 1e-4);
  }
  EXPECT_EQ(model.finest_step_m(), 2.0);
  EXPECT_FALSE(model.at(kWest - 0.1, kSouth + 50));
  EXPECT_TRUE(model.at(kWest + 0.1, kSouth + 50)) << "half a pixel before the first centre";
}

TEST_F(ElevationModelTest, GoesOnWithoutAStepFromOneRasterToTheNext) {
  const auto model =
      ElevationModel::read({write("a.tif", raster(kWest, kSouth, 25, 2.0, slope)),
                            write("b.tif", raster(kWest + 50, kSouth, 25, 2.0, slope))},
                           kCrs, kArea);
  EXPECT_EQ(model.rasters_used(), 2u);
  for (double x = 48.05; x < 52; x += 0.1) {
    ASSERT_TRUE(model.at(kWest + x, kSouth + 20.3));
    EXPECT_NEAR(model.at(kWest + x, kSouth + 20.3)->height_m, slope(kWest + x, kSouth + 20.3),
                1e-4);
  }
}

TEST_F(ElevationModelTest, SaysTheSameOfAPlaceWhateverAreaWasAskedFor) {
  const auto rough = [](double x, double y) { return 3.0 * std::sin(x) + 2.0 * std::cos(1.3 * y); };
  const std::vector<fs::path> files{
      write("a.tif", raster(kWest + 0.3, kSouth - 20.7, 90, 1.0, rough)),
      write("b.tif", raster(kWest + 40, kSouth, 60, 0.5, rough))};
  const auto west = ElevationModel::read(files, kCrs, {kWest, kSouth, kWest + 50, kSouth + 50});
  const auto east =
      ElevationModel::read(files, kCrs, {kWest + 50, kSouth, kWest + 99, kSouth + 60});
  int seen = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    CounterRandom random(8, 1, i);
    const double y = kSouth + random.uniform(0, 50);
    const auto a = west.at(kWest + 50, y), b = east.at(kWest + 50, y);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    EXPECT_EQ(a->height_m, b->height_m);
    EXPECT_EQ(a->normal, b->normal);
    ++seen;
  }
  EXPECT_EQ(seen, 400);
}

TEST_F(ElevationModelTest, TakesTheFinerRasterAndTheCoarserWhereThatHasNoData) {
  const auto holey = [](double x, double) { return x > kWest + 60 ? NAN : 7.0; };
  const auto model = ElevationModel::read(
      {write("coarse.tif", raster(kWest, kSouth, 20, 5.0, [](double, double) { return 3.0; })),
       write("fine.tif", raster(kWest, kSouth, 100, 1.0, holey))},
      kCrs, kArea);
  EXPECT_EQ(model.at(kWest + 30, kSouth + 30)->height_m, 7.0);
  EXPECT_EQ(model.at(kWest + 80, kSouth + 30)->height_m, 3.0);
  EXPECT_EQ(model.at(kWest + 59.9, kSouth + 30)->height_m, 7.0);
}

TEST_F(ElevationModelTest, RefusesRastersOfAnotherSystemInOneLine) {
  const auto flat = [](double, double) { return 1.0; };
  const auto file = [&](const std::string& name, const std::string& crs) {
    return write(name, raster(kWest, kSouth, 4, 1.0, flat, crs));
  };
  EXPECT_THAT(problem(file("france.tif", "EPSG:2154+5720")),
              HasSubstr("has EPSG:2154+5720, but what it is to fill has EPSG:2056+5728"));
  EXPECT_THAT(problem(file("heights.tif", "EPSG:2056+5729")), HasSubstr("EPSG:2056+5729"));
  EXPECT_THAT(problem(file("none.tif", "")), HasSubstr("has no CRS"));
  EXPECT_EQ(problem(file("far.tif", "EPSG:2056+5729")).find('\n'), std::string::npos);
  EXPECT_EQ(problem(file("plan.tif", "EPSG:2056")), "accepted");
  EXPECT_EQ(ElevationModel::read({folder_ / "plan.tif"}, kCrs, kArea).without_vertical(), 1u);
  EXPECT_EQ(problem(file("bare.tif", ""), ""), "accepted") << "neither says anything";
  EXPECT_NE(problem(folder_ / "missing.tif"), "accepted");
}

TEST_F(ElevationModelTest, RefusesHeightsThatStandForNoDataUntold) {
  Raster r = raster(kWest, kSouth, 4, 1.0, [](double, double) { return 1.0; });
  r.values[5] = -3.4028235e38f;
  EXPECT_THAT(
      problem(write("untold.tif", r)),
      HasSubstr("has a height of -3.40282347e+38 m, which no ground has; if it stands for"));
  r.no_data = -3.4028235e38f;
  EXPECT_EQ(problem(write("told.tif", r)), "accepted");
}

TEST_F(ElevationModelTest, LeavesOutRastersThatDoNotTouchTheArea) {
  const auto model = ElevationModel::read(
      {write("far.tif", raster(kWest + 5000, kSouth, 20, 1.0, slope))}, kCrs, kArea);
  EXPECT_TRUE(model.empty());
  EXPECT_EQ(model.rasters_used(), 0u);
  EXPECT_FALSE(model.at(kWest + 50, kSouth + 50));
}

}  // namespace
}  // namespace cornice
