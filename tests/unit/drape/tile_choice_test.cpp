// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/drape/tile_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_set>

#include "core/base/random.h"

namespace cornice::viewer {
namespace {

const PyramidGrid kGrid = make_grid(60000, 40000, 2600000.0, 1200000.0, 0.25, 0.25);

TileView random_view(std::uint64_t seed) {
  CounterRandom random(3, seed, 0);
  TileView view;
  view.camera.eye = {random.uniform(2598000.0, 2617000.0), random.uniform(1188000.0, 1202000.0),
                     random.uniform(800.0, 6000.0)};
  view.camera.heading_deg = random.uniform(0.0, 360.0);
  view.camera.pitch_deg = random.uniform(-90.0, 10.0);
  view.camera.field_of_view_deg = random.uniform(10.0, 70.0);
  view.width_over_height = 1.6;
  view.height_pixels = 900.0;
  view.lowest_m = 700.0;
  view.highest_m = 1500.0;
  return view;
}

TEST(TileChoice, HoldsNoMoreThanItsLimitAndEveryParent) {
  std::size_t with_tiles = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed)
    for (const std::size_t limit : {std::size_t{1}, std::size_t{40}, std::size_t{600}}) {
      const auto keys = wanted_tiles(kGrid, random_view(seed), limit);
      ASSERT_LE(keys.size(), limit);
      std::unordered_set<TileKey, TileKeyHash> before;
      for (const TileKey& key : keys) {
        ASSERT_LT(key.column, kGrid.columns(key.level));
        ASSERT_LT(key.row, kGrid.rows(key.level));
        if (key.level < kGrid.levels - 1) {
          ASSERT_TRUE(before.contains({key.level + 1, key.column / 2, key.row / 2}));
        }
        before.insert(key);
      }
      ASSERT_EQ(before.size(), keys.size()) << "a tile is wanted twice";
      with_tiles += keys.empty() ? 0 : 1;
    }
  EXPECT_GT(with_tiles, 100u);
}

TEST(TileChoice, HasTexelsNoLargerThanAPixelWhereverTheGroundIsSeen) {
  CounterRandom random(4, 0, 0);
  std::size_t checked = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const TileView view = random_view(seed);
    const auto keys = wanted_tiles(kGrid, view, 100000);
    const std::unordered_set<TileKey, TileKeyHash> held(keys.begin(), keys.end());
    const int width = int(view.width_over_height * view.height_pixels);
    const int height = int(view.height_pixels);
    for (int i = 0; i < 200; ++i) {
      const Vec3d ray = ray_of_pixel(view.camera, width, height, random.uniform(0.0, width),
                                     random.uniform(0.0, height));
      const double z = random.uniform(view.lowest_m, view.highest_m);
      const double away = (z - view.camera.eye.z) / ray.z;
      if (!(away > 0.0)) continue;
      const Vec3d place = view.camera.eye + away * ray;
      const double x = (place.x - kGrid.west) / kGrid.texel_x;
      const double y = (kGrid.north - place.y) / kGrid.texel_y;
      if (x < 0.0 || y < 0.0 || x >= kGrid.width || y >= kGrid.height) continue;
      int level = 0;
      while (level < kGrid.levels &&
             !held.contains({level, int(x / 256.0) >> level, int(y / 256.0) >> level}))
        ++level;
      ASSERT_LT(level, kGrid.levels) << "seen, but no tile is wanted there";
      const double pixel = 2.0 *
                           std::tan(0.5 * view.camera.field_of_view_deg * std::numbers::pi / 180) /
                           view.height_pixels * away;
      if (level > 0) {
        ASSERT_LE(std::ldexp(kGrid.texel_x, level), pixel * (1.0 + 1e-9));
      }
      ++checked;
    }
  }
  EXPECT_GT(checked, 1000u);
}

TEST(TileChoice, PutsCoarseTilesBeforeFineOnesAndNearOnesBeforeFarOnes) {
  TileView view = random_view(1);
  view.camera.eye = {2607000.0, 1195000.0, 1700.0};
  view.camera.heading_deg = 0.0;
  view.camera.pitch_deg = -15.0;
  const auto keys = wanted_tiles(kGrid, view, 500);
  ASSERT_GT(keys.size(), 50u);
  const auto away = [&](TileKey key) {
    const double side = std::ldexp(64.0, key.level);
    return std::max(0.0, kGrid.north - (key.row + 1) * side - view.camera.eye.y);
  };
  for (std::size_t i = 1; i < keys.size(); ++i) ASSERT_GE(keys[i - 1].level, keys[i].level);
  const auto finest = std::find_if(keys.begin(), keys.end(),
                                   [&](TileKey key) { return key.level == keys.back().level; });
  EXPECT_LE(away(*finest), away(keys.back()));
}

TEST(TileChoice, WantsNothingThatIsBehind) {
  TileView view = random_view(2);
  view.camera.eye = {2600000.0 - 500.0, 1195000.0, 1600.0};
  view.camera.heading_deg = 270.0;
  view.camera.pitch_deg = 0.0;
  EXPECT_TRUE(wanted_tiles(kGrid, view, 500).empty());
  view.camera.heading_deg = 90.0;
  EXPECT_FALSE(wanted_tiles(kGrid, view, 500).empty());
}

}  // namespace
}  // namespace cornice::viewer
