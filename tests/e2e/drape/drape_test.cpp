// SPDX-License-Identifier: GPL-3.0-or-later
// cornice-viewer with rasters over the ground, without a window.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/ply.h"
#include "terrain-viewer/scene/camera_file.h"
#include "tests/support/meshes.h"
#include "tests/support/picture.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/drape/made_raster.h"

namespace cornice::viewer {
namespace {

using test::ProcessResult;
using test::run_process;

const std::string kHlod = CORNICE_BIN_DIR "/cornice-hlod";
const std::string kViewer = CORNICE_BIN_DIR "/cornice-viewer";
constexpr double kWest = 2600000.0, kSouth = 1200000.0, kGroundM = 1800.0;
constexpr int kSide = 240;

double gentle(double x, double y) { return 2.0 * std::sin(0.05 * x) * std::cos(0.04 * y); }

/// A picture of gentle ground from straight above, north up: pixels per metre is kPerMetre.
class Drape : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    Mesh mesh = test::height_mesh(0.0, 0.0, 240, 1.0, gentle);
    mesh.origin = {kWest, kSouth, kGroundM};
    mesh.crs_text = "EPSG:2056+5728";
    write_ply(*folder_ / "ground.ply", mesh);
    const ProcessResult built =
        run_process({kHlod, "build", *folder_ / "ground.ply", "-o", *folder_ / "ground.hlod",
                     "--triangles-per-cell", "4000", "--no-progress"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    Camera camera;
    camera.eye = {kWest + 120.0, kSouth + 120.0, kGroundM + 600.0};
    camera.pitch_deg = -90.0;
    camera.field_of_view_deg = 2.0 * std::atan(120.0 / 600.0) * 57.29577951308232;
    write_camera(at("above.json"), camera);
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string at(const std::string& name) { return (*folder_ / name).string(); }
  static ProcessResult view(const std::string& picture, std::vector<std::string> more,
                            const std::string& size = "240x240",
                            const std::string& camera = "above.json") {
    std::vector<std::string> arguments{kViewer,      at("ground.hlod"),
                                       "--headless", "--no-progress",
                                       "--no-sky",   "--camera",
                                       at(camera),   "--size",
                                       size,         "-o",
                                       at(picture)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_process(arguments);
  }
  /// Of the ground at so many metres from its south-western corner.
  static std::array<std::uint8_t, 3> colour(const Picture& picture, double x, double y) {
    const auto column = static_cast<std::size_t>(x), row = static_cast<std::size_t>(240.0 - y);
    return picture.pixels[row * static_cast<std::size_t>(picture.width) + column];
  }

  static inline test::TemporaryFolder* folder_ = nullptr;
};

/// Photograph of 0.25 m: red in the south-west, green in the south-east, blue in the north-west;
/// grey 40 in the north-east, with a hole in its middle.
void make_photo(const std::filesystem::path& file) {
  test::MadeRaster raster{4 * kSide, 4 * kSide, 4};
  raster.transform = {kWest, 0.25, 0.0, kSouth + kSide, 0.0, -0.25};
  test::make_tiff(file, raster, [](int b, int column, int row) {
    const double x = 0.25 * column, y = kSide - 0.25 * row;
    const bool is_east = x >= 120.0, is_north = y >= 120.0;
    if (b == 3) return std::hypot(x - 180.0, y - 180.0) < 20.0 ? 0.0 : 255.0;
    if (is_east && is_north) return 40.0;
    const int channel = is_east ? 1 : is_north ? 2 : 0;
    return b == channel ? 220.0 : 10.0;
  });
}

void expect_near(std::array<std::uint8_t, 3> got, std::array<int, 3> wanted, int off) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(int(got[c]), wanted[c], off) << "channel " << c;
}

TEST_F(Drape, ShowsThePhotographWhereItLiesAndTheGroundsOwnColoursElsewhere) {
  make_photo(at("photo.tif"));
  const std::vector<std::string> plain{"--shading", "plain"};
  ASSERT_EQ(view("bare.png", plain).exit_code, 0);
  const ProcessResult drawn =
      view("photo.png", {"--shading", "plain", "--orthophoto", at("photo.tif")});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  ASSERT_EQ(view("again.png", {"--shading", "plain", "--orthophoto", at("photo.tif")}).exit_code,
            0);
  EXPECT_EQ(test::read_text(at("photo.png")), test::read_text(at("again.png")));
  const Picture photo = test::read_png(at("photo.png")), bare = test::read_png(at("bare.png"));
  // A quarter of it is lit like the ground: colours keep their kind, not every bit.
  expect_near(colour(photo, 60, 60), {220, 10, 10}, 45);
  expect_near(colour(photo, 200, 40), {10, 220, 10}, 45);
  expect_near(colour(photo, 40, 200), {10, 10, 220}, 45);
  expect_near(colour(photo, 225, 225), {40, 40, 40}, 25);
  EXPECT_EQ(colour(photo, 180, 180), colour(bare, 180, 180)) << "in the hole";
  // Borders are where they should be, to a pixel.
  for (const double along : {30.0, 100.0}) {
    EXPECT_GT(colour(photo, 118, along)[0], 150);
    EXPECT_LT(colour(photo, 122, along)[0], 60);
    EXPECT_GT(colour(photo, along, 118)[0], 150);
    EXPECT_LT(colour(photo, along, 122)[0], 60);
  }
}

TEST_F(Drape, ShowsDifferencesInTheColoursOfTheirRamp) {
  test::MadeRaster raster{kSide, kSide, 1, GDT_Float32};
  raster.transform = {kWest, 1.0, 0.0, kSouth + kSide, 0.0, -1.0};
  raster.has_no_data = true;
  raster.no_data = -9999.0;
  test::make_tiff(at("difference.tif"), raster, [](int, int column, int row) {
    if (row < 60) return -9999.0;
    return column < 80 ? -3.0 : column < 160 ? 0.0 : 3.0;
  });
  ASSERT_EQ(view("bare2.png", {}).exit_code, 0);
  const ProcessResult drawn =
      view("difference.png", {"--difference", at("difference.tif"), "--difference-range-m", "2"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  const Picture picture = test::read_png(at("difference.png"));
  const auto low = colour(picture, 40, 90), none = colour(picture, 120, 90),
             high = colour(picture, 200, 90);
  EXPECT_GT(int(low[2]), int(low[0]) + 60) << "blue below";
  EXPECT_GT(int(high[0]), int(high[2]) + 60) << "red above";
  EXPECT_NEAR(int(none[0]), int(none[2]), 25) << "neither where there is none";
  EXPECT_EQ(colour(picture, 120, 220), colour(test::read_png(at("bare2.png")), 120, 220));
}

TEST_F(Drape, LiesBesideTheGroundsOwnColoursWhereAskedTo) {
  make_photo(at("beside.tif"));
  const ProcessResult drawn =
      view("half.png", {"--orthophoto", at("beside.tif"), "--side-by-side"}, "480x240");
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  ASSERT_EQ(view("left.png", {}).exit_code, 0);
  ASSERT_EQ(view("right.png", {"--orthophoto", at("beside.tif")}).exit_code, 0);
  const Picture both = test::read_png(at("half.png"));
  const Picture left = test::read_png(at("left.png")), right = test::read_png(at("right.png"));
  std::size_t wrong = 0;
  for (std::size_t row = 0; row < 240; ++row)
    for (std::size_t column = 0; column < 240; ++column) {
      wrong += both.pixels[row * 480 + column] != left.pixels[row * 240 + column] ? 1 : 0;
      wrong += both.pixels[row * 480 + 240 + column] != right.pixels[row * 240 + column] ? 1 : 0;
    }
  // Places in a picture are rounded to parts of a pixel from its left edge.
  EXPECT_LE(wrong, 20u) << "two pictures in one are the two pictures";
}

TEST_F(Drape, CountsHowOftenPixelsAreDrawn) {
  const ProcessResult drawn =
      view("overdraw.png", {"--shading", "overdraw", "--report", at("overdraw.json")});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  std::ifstream report(at("overdraw.json"));
  const double ratio = nlohmann::json::parse(report)["quality"]["overdraw, median"].get<double>();
  // Gentle ground from straight above hides nothing of itself.
  EXPECT_EQ(ratio, 1.0);
  const Picture picture = test::read_png(at("overdraw.png"));
  EXPECT_EQ(colour(picture, 120, 120), (std::array<std::uint8_t, 3>{41, 64, 115}));
  Camera camera;
  camera.eye = {kWest + 120.0, kSouth - 10.0, kGroundM + 1.0};
  camera.pitch_deg = -1.0;
  write_camera(at("low.json"), camera);
  const ProcessResult low_drawn = view(
      "low.png", {"--shading", "overdraw", "--report", at("low_r.json")}, "240x240", "low.json");
  ASSERT_EQ(low_drawn.exit_code, 0) << low_drawn.err;
  std::ifstream low(at("low_r.json"));
  EXPECT_GT(nlohmann::json::parse(low)["quality"]["overdraw, median"].get<double>(), 1.0)
      << "waves hide each other seen from the side";
}

TEST_F(Drape, RefusesRastersThatItCannotUseInOneLine) {
  test::write_text(at("text.tif"), "no raster");
  const auto expect = [&](const ProcessResult& result, int code, const std::string& part) {
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(test::line_count(result.err), 1u) << result.err;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  };
  expect(view("x.png", {"--orthophoto", at("text.tif")}), 3, "text.tif");
  expect(view("x.png", {"--difference", at("missing.tif")}), 3, "missing.tif");
  expect(view("x.png", {"--difference-range-m", "0"}), 2, "--difference-range-m");
  expect(run_process({kViewer, "--headless", "-o", at("x.png")}), 2, "FILE");
}

}  // namespace
}  // namespace cornice::viewer
