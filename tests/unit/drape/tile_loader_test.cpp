// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/drape/tile_loader.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/temporary_folder.h"
#include "tests/unit/drape/made_raster.h"

namespace cornice::viewer {
namespace {

class Loader : public testing::Test {
 protected:
  void SetUp() override {
    test::make_tiff(folder_ / "photo.tif", {2600, 2600, 1},
                    [](int, int column, int row) { return (column / 256 * 11 + row / 256) % 256; });
  }
  std::unique_ptr<RasterPyramid> pyramid() {
    return std::make_unique<RasterPyramid>(
        std::vector<std::filesystem::path>{folder_ / "photo.tif"}, RasterKind::kPhoto, "");
  }
  static std::vector<TileKey> all_tiles() {
    std::vector<TileKey> keys;
    for (int row = 0; row < 11; ++row)
      for (int column = 0; column < 11; ++column) keys.push_back({0, column, row});
    return keys;
  }
  test::TemporaryFolder folder_;
};

TEST_F(Loader, ReadsAllThatIsWantedInItsOrderHoweverManyAreTaken) {
  TileLoader loader(pyramid());
  const std::vector<TileKey> wanted = all_tiles();
  loader.want(wanted);
  std::vector<TileKey> got;
  while (got.size() < wanted.size()) {
    loader.wait();
    const auto tiles = loader.take(5);
    ASSERT_FALSE(tiles.empty());
    for (const RasterTile& tile : tiles) {
      got.push_back(tile.key);
      EXPECT_EQ(tile.bytes[(kTileSide * 20 + 20) * 4], (tile.key.column * 11 + tile.key.row) % 256);
    }
  }
  EXPECT_EQ(got, wanted);
  EXPECT_EQ(loader.tiles_read(), wanted.size());
  EXPECT_TRUE(loader.take(100).empty());
}

TEST_F(Loader, HoldsNoMoreReadyThanItsLimit) {
  TileLoader loader(pyramid());
  loader.want(all_tiles());
  loader.wait();
  EXPECT_EQ(loader.tiles_read(), TileLoader::kMostReady);
  EXPECT_EQ(loader.take(1000).size(), TileLoader::kMostReady);
}

TEST_F(Loader, ForgetsWhatIsNoLongerWanted) {
  TileLoader loader(pyramid());
  loader.want(all_tiles());
  loader.want({{0, 10, 10}});
  std::vector<TileKey> got;
  for (loader.wait();; loader.wait()) {
    const auto tiles = loader.take(1000);
    if (tiles.empty()) break;
    for (const RasterTile& tile : tiles) got.push_back(tile.key);
  }
  ASSERT_FALSE(got.empty());
  EXPECT_EQ(got.back(), (TileKey{0, 10, 10}));
  EXPECT_LE(got.size(), TileLoader::kMostReady + 1);
}

TEST_F(Loader, NamesWhatCannotBeReadOnceAndGoesOn) {
  auto opened = pyramid();
  // The lower half of the file goes away: its first rows can still be read.
  std::filesystem::resize_file(folder_ / "photo.tif",
                               std::filesystem::file_size(folder_ / "photo.tif") / 2);
  TileLoader loader(std::move(opened));
  loader.want({{0, 0, 10}, {0, 3, 1}});
  loader.wait();
  EXPECT_TRUE(loader.has_failed({0, 0, 10}));
  EXPECT_FALSE(loader.has_failed({0, 3, 1}));
  const auto tiles = loader.take(10);
  ASSERT_EQ(tiles.size(), 1u);
  EXPECT_EQ(tiles[0].key, (TileKey{0, 3, 1}));
  const auto failures = loader.take_failures();
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_NE(failures[0].find("photo.tif"), std::string::npos) << failures[0];
  loader.want({{0, 0, 10}});
  loader.wait();
  EXPECT_TRUE(loader.take_failures().empty());
}

}  // namespace
}  // namespace cornice::viewer
