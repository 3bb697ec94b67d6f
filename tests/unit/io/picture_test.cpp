// SPDX-License-Identifier: GPL-3.0-or-later
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "core/io/raster.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::read_text;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::IsEmpty;

Picture some_picture() {
  Picture picture;
  picture.width = 5;
  picture.height = 4;
  for (int i = 0; i < 20; ++i) {
    picture.pixels.push_back(
        {static_cast<std::uint8_t>(12 * i), static_cast<std::uint8_t>(255 - i), 7});
  }
  return picture;
}

TEST(Picture, IsReadBackFromPngToTheLastBit) {
  const TemporaryFolder folder;
  const Picture picture = some_picture();
  write_picture(folder / "a.png", picture);
  const auto input = OIIO::ImageInput::open((folder / "a.png").string());
  ASSERT_TRUE(input);
  EXPECT_EQ(input->spec().width, 5);
  EXPECT_EQ(input->spec().height, 4);
  ASSERT_EQ(input->spec().nchannels, 3);
  std::vector<std::array<std::uint8_t, 3>> pixels(20);
  ASSERT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.data()));
  EXPECT_EQ(pixels, picture.pixels);
  EXPECT_THAT(folder.entries(), ElementsAre("a.png"));
}

TEST(Picture, IsTheSameBytesAgain) {
  const TemporaryFolder folder;
  for (const char* name : {"a.png", "b.png", "a.jpg", "b.JPG"}) {
    write_picture(folder / name, some_picture());
  }
  EXPECT_EQ(read_text(folder / "a.png"), read_text(folder / "b.png"));
  EXPECT_EQ(read_text(folder / "a.jpg"), read_text(folder / "b.JPG"));
  EXPECT_EQ(read_text(folder / "a.jpg").substr(0, 2), "\xff\xd8");
}

TEST(Picture, RefusesOtherFormatsAndShapes) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_picture(folder / "a.gif", some_picture()), RunError);
  EXPECT_THROW(write_picture(folder / "a", some_picture()), RunError);
  EXPECT_THROW(write_picture("/proc/nowhere/a.png", some_picture()), RunError);
  EXPECT_THROW(write_picture(folder / "a.png", Picture{}), std::invalid_argument);
  EXPECT_THAT(folder.entries(), IsEmpty());
}

/// height(east, north) in pixels of 2 m, north up.
template <class Height>
Raster slope(Height height) {
  Raster raster;
  raster.width = raster.height = 9;
  raster.step = 2.0;
  for (int row = 0; row < 9; ++row) {
    for (int col = 0; col < 9; ++col) {
      raster.values.push_back(static_cast<float>(height(2.0 * col, -2.0 * row)));
    }
  }
  return raster;
}

int grey_in_the_middle(const Raster& raster, double azimuth_deg, double altitude_deg) {
  return hillshade(raster, azimuth_deg, altitude_deg).pixels[4 * 9 + 4][0];
}

TEST(Hillshade, OfLevelGroundIsTheSineOfTheLightsAltitude) {
  const Raster level = slope([](double, double) { return 100.0; });
  EXPECT_EQ(grey_in_the_middle(level, 315.0, 45.0), std::lround(255.0 * std::sqrt(0.5)));
  EXPECT_EQ(grey_in_the_middle(level, 10.0, 90.0), 255);
  EXPECT_EQ(grey_in_the_middle(level, 10.0, 60.0), std::lround(255.0 * std::sqrt(0.75)));
}

TEST(Hillshade, OfAPlaneIsTheCosineBetweenNormalAndLight) {
  // Rises 1 m per metre towards the east: faces west, inclined by 45 degrees.
  const Raster faces_west = slope([](double east, double) { return east; });
  EXPECT_EQ(grey_in_the_middle(faces_west, 270.0, 45.0), 255);
  EXPECT_EQ(grey_in_the_middle(faces_west, 90.0, 45.0), 0);
  const Raster faces_south = slope([](double, double north) { return north; });
  EXPECT_EQ(grey_in_the_middle(faces_south, 180.0, 45.0), 255);
  EXPECT_EQ(grey_in_the_middle(faces_south, 0.0, 45.0), 0);
}

TEST(Hillshade, PaintsHolesInTheBackgroundAndKeepsTheirNeighboursLevel) {
  Raster level = slope([](double, double) { return 100.0; });
  level.values[40] = level.no_data;
  const Picture picture = hillshade(level, 315.0, 45.0, {1, 2, 3});
  EXPECT_EQ(picture.pixels[40], (std::array<std::uint8_t, 3>{1, 2, 3}));
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    if (i == 40) continue;
    EXPECT_EQ(picture.pixels[i], picture.pixels[0]) << i;
  }
}

}  // namespace
}  // namespace cornice
