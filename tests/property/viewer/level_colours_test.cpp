// SPDX-License-Identifier: GPL-3.0-or-later
// The shading by level shows what is drawn: of a cell that has morphed, the level above.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "terrain-viewer/app/picture.h"
#include "terrain-viewer/scene/ramp.h"
#include "tests/property/viewer/crater_fixture.h"

namespace cornice::viewer {
namespace {

class LevelColours : public CraterFixture {};

constexpr int kWidth = 160, kHeight = 120;

/// IEC 61966-2-1.
double light_of(int value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// Red, green and blue without how bright they are, largest 1.
std::array<double, 3> hue_of(const std::array<double, 3>& light) {
  const double most = std::max({light[0], light[1], light[2], 1e-9});
  return {light[0] / most, light[1] / most, light[2] / most};
}

std::array<double, 3> light_of(const Colour& c) {
  return {light_of(c[0]), light_of(c[1]), light_of(c[2])};
}

/// Of the pixels with ground, the share whose hue is that of `light`, however bright.
double share_like(const Picture& picture, const std::array<double, 3>& light) {
  const auto wanted = hue_of(light);
  double like = 0.0, all = 0.0;
  for (const auto& pixel : picture.pixels) {
    if (pixel == kMagenta) continue;
    const auto hue = hue_of({light_of(pixel[0]), light_of(pixel[1]), light_of(pixel[2])});
    double off = 0.0;
    for (std::size_t c = 0; c < 3; ++c) off = std::max(off, std::abs(hue[c] - wanted[c]));
    like += off < 0.03 ? 1.0 : 0.0;
    all += 1.0;
  }
  EXPECT_GT(all, 500.0) << "nothing to be seen";
  return like / all;
}

Picture draw(const CraterStudio& studio, const DrawList& list, const Camera& camera,
             Shading shading) {
  TerrainRenderer renderer;
  const Target target(kWidth, kHeight, 1);
  Style style;
  style.shading = shading;
  style.haze_range_m = 0.0;
  renderer.begin(target.framebuffer(), kWidth, kHeight, camera, style, &kMagenta);
  renderer.draw(list, studio.cells(), style);
  return read_picture(target);
}

/// The cells of one level, all of whose vertices are at `eighths` of the way from their parents' to
/// their own.
DrawList morphed_alike(const DrawList& list, int level, int eighths) {
  DrawList own = list;
  std::erase_if(own.items, [&](const DrawList::Item& item) {
    return (*list.nodes)[item.row].key.level != level;
  });
  hlod::MorphBand& band = own.bands[static_cast<std::size_t>(level)];
  // Distances are nothing beside such steps: t of hlod/morph.h is `eighths` of 8.
  band.shift = 27;
  band.band = 8;
  band.end = eighths == 0 ? -1 : (eighths << band.shift) + (1 << 26);
  return own;
}

TEST_F(LevelColours, AreMixedAsVerticesAre) {
  CraterStudio studio(crater_file(), kWidth, kHeight, {});
  const Camera camera = crater_camera(0.1);
  ASSERT_TRUE(studio.settle(camera, 2.0));
  const DrawList& list = studio.layer().list();
  int level = 0;
  for (const DrawList::Item& item : list.items)
    level = std::max(level, int{(*list.nodes)[item.row].key.level});
  ASSERT_GT(level, 0);
  const auto own = light_of(level_colour(level)), above = light_of(level_colour(level - 1));
  for (const int eighths : {0, 3, 5}) {
    const Picture picture =
        draw(studio, morphed_alike(list, level, eighths), camera, Shading::kLevel);
    const double lambda = eighths / 8.0;
    std::array<double, 3> mixed{};
    for (std::size_t c = 0; c < 3; ++c) mixed[c] = lambda * own[c] + (1.0 - lambda) * above[c];
    EXPECT_GT(share_like(picture, mixed), 0.98) << eighths;
    EXPECT_LT(share_like(picture, own), 0.02) << eighths;
  }
  DrawList plain = without_morphing(list);
  plain.items = morphed_alike(list, level, 0).items;
  EXPECT_GT(share_like(draw(studio, plain, camera, Shading::kLevel), own), 0.98);
}

TEST_F(LevelColours, OfCellsAreTheirOwnWhereverTheirVerticesAre) {
  CraterStudio studio(crater_file(), kWidth, kHeight, {});
  const Camera camera = crater_camera(0.1);
  ASSERT_TRUE(studio.settle(camera, 2.0));
  DrawList list = studio.layer().list();
  list.items.resize(1);
  const std::uint32_t row = list.items[0].row;
  const int level = (*list.nodes)[row].key.level;
  ASSERT_GT(level, 0);
  EXPECT_GT(share_like(draw(studio, morphed_alike(list, level, 3), camera, Shading::kCell),
                       light_of(cell_colour(level, row))),
            0.98);
}

}  // namespace
}  // namespace cornice::viewer
