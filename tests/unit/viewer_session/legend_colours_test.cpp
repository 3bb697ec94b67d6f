// SPDX-License-Identifier: GPL-3.0-or-later
// Colours on the ground are those of the legend where it faces the sun, and darker elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "terrain-viewer/render/offscreen_context.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/drape/made_raster.h"
#include "tests/unit/viewer_session/plates.h"

namespace cornice::viewer {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

/// Ground that rises to the east.
Vec3d normal_of(double slope_deg) {
  return {-std::sin(slope_deg * kRadians), 0.0, std::cos(slope_deg * kRadians)};
}

class LegendColours : public testing::Test {
 protected:
  std::filesystem::path plate(double slope_deg) {
    const std::filesystem::path path = folder_ / ("s" + std::to_string(slope_deg) + ".hlod");
    const double rise = std::tan(slope_deg * kRadians);
    write_plate(path, [&](double x, double) { return rise * (x - 0.5 * kPlateM); },
                {120, 120, 120});
    return path;
  }
  /// A difference of 0.4 m everywhere.
  std::filesystem::path differences() {
    const Vec3d corner = plate_corner();
    test::MadeRaster raster{100, 100, 1, GDT_Float32};
    raster.transform = {corner.x, 1.0, 0.0, corner.y + kPlateM, 0.0, -1.0};
    test::make_tiff(folder_ / "d.tif", raster, [](int, int, int) { return 0.4; });
    return folder_ / "d.tif";
  }
  static void expect_near(Colour drawn, Colour legend, const std::string& what) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(drawn[c], legend[c], 2.0) << what << ' ' << c;
  }

  test::TemporaryFolder folder_;
  OffscreenContext context_;
};

TEST_F(LegendColours, AreDrawnAsTheyAreWhereTheGroundFacesTheSun) {
  for (const double slope : {0.0, 32.0, 37.0, 50.0}) {
    Desk desk({plate(slope)});
    Style& style = desk.session().style();
    style.sun = normal_of(slope);
    for (const Shading shading : {Shading::kSlope, Shading::kAltitude, Shading::kSupport}) {
      style.shading = shading;
      const double value = shading == Shading::kSlope      ? slope
                           : shading == Shading::kAltitude ? plate_corner().z
                                                           : 0.0;
      expect_near(desk.middle(), ramp_of(style)->at(value), kShadingNames[std::size_t(shading)]);
    }
    // So fine that nothing has morphed towards another level.
    Desk finest({plate(slope)}, 1e-4);
    finest.session().style().sun = normal_of(slope);
    finest.session().style().shading = Shading::kLevel;
    const Colour drawn = finest.middle();
    const Layer& layer = *finest.session().layers()[0];
    expect_near(drawn, level_colour(layer.tree().cells[layer.chosen()[0]].key.level), "level");
  }
}

TEST_F(LegendColours, OfADifferenceMapAreThoseOfItsLegendWhateverLiesBelow) {
  const std::filesystem::path raster = differences();
  for (const double slope : {0.0, 37.0}) {
    Desk desk({plate(slope)});
    desk.session().add_drape({raster}, RasterKind::kValues);
    Style& style = desk.session().style();
    style.sun = normal_of(slope);
    style.difference_high_m = 0.5;
    for (const Shading shading : {Shading::kNatural, Shading::kPlain, Shading::kSlope}) {
      style.shading = shading;
      expect_near(desk.middle(), difference_ramp(0.5).at(0.4), kShadingNames[std::size_t(shading)]);
    }
  }
}

TEST_F(LegendColours, AreNeverLighterAndKeepTheirHueInAnyLight) {
  const double slope = 37.0;
  Desk desk({plate(slope)});
  Style& style = desk.session().style();
  style.shading = Shading::kSlope;
  const Colour legend = slope_ramp().at(slope);
  for (int azimuth = 0; azimuth < 360; azimuth += 30) {
    for (const double elevation : {-5.0, 5.0, 30.0, 60.0, 90.0}) {
      style.sun = sun_direction(azimuth, elevation);
      const Colour drawn = desk.middle();
      for (std::size_t c = 0; c < 3; ++c) EXPECT_LE(drawn[c], legend[c] + 1) << azimuth;
      EXPECT_GE(drawn[0], drawn[1]) << azimuth << ' ' << elevation;
      EXPECT_GE(drawn[1], drawn[2]) << azimuth << ' ' << elevation;
    }
  }
  style.sun = sun_direction(90.0, 10.0);
  EXPECT_LT(desk.middle()[0], legend[0] - 50) << "relief is to be seen all the same";
}

TEST_F(LegendColours, AreNotLostInHaze) {
  Desk desk({plate(37.0)});
  Style& style = desk.session().style();
  style.sun = normal_of(37.0);
  style.haze_range_m = 50.0;
  style.haze_height_m = 0.0;
  style.shading = Shading::kSlope;
  expect_near(desk.middle(), slope_ramp().at(37.0), "slope");
  style.shading = Shading::kPlain;
  const Colour hazy = desk.middle();
  style.haze_range_m = 0.0;
  EXPECT_NE(desk.middle(), hazy) << "there is no haze to be lost in";
}

}  // namespace
}  // namespace cornice::viewer
