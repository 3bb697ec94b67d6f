// SPDX-License-Identifier: GPL-3.0-or-later
// What tiles of a draped raster take up on the GPU, and that the shader is told where they are.
#include "terrain-viewer/render/drape_texture.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "terrain-viewer/render/drape.h"
#include "terrain-viewer/render/offscreen_context.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/drape/made_raster.h"

namespace cornice::viewer {
namespace {

constexpr std::uint64_t kTileBytes = std::uint64_t{kTileSide} * kTileSide * 4;
constexpr std::uint64_t kBudget = 105 * kTileBytes;
/// Tiles, at most and at first.
constexpr std::uint64_t kRoom = 68, kAtFirst = 17;

/// 16 x 16 tiles of 1 m, and coarser ones.
PyramidGrid grid_of_many() { return make_grid(4096, 4096, 0.0, 4096.0, 1.0, 1.0); }
constexpr Vec3d kMiddle{2048.0, 2048.0, 100.0};

TileKey key(int number) { return {0, number % 16, number / 16}; }

/// Every byte says which tile it is.
RasterTile marked_tile(int number) {
  return {key(number), std::vector<std::uint8_t>(kTileBytes, static_cast<std::uint8_t>(number))};
}

GLuint bound_to(GLuint unit) {
  glActiveTexture(GL_TEXTURE0 + unit);
  GLint id = 0;
  glGetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &id);
  glActiveTexture(GL_TEXTURE0);
  return static_cast<GLuint>(id);
}

/// The tile's bytes where the shader would look for them; empty where the table has none.
std::vector<std::uint8_t> bytes_found(DrapeTexture& texture, int number) {
  texture.bind(kMiddle);
  const TileKey tile = key(number);
  std::uint16_t entry = 0;
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureSubImage(bound_to(2), 0, tile.column, tile.row, 0, 1, 1, 1, GL_RED_INTEGER,
                       GL_UNSIGNED_SHORT, sizeof entry, &entry);
  if (entry == 0) return {};
  std::vector<std::uint8_t> bytes(kTileBytes);
  glGetTextureSubImage(bound_to(1), 0, 0, 0, entry - 1, kTileSide, kTileSide, 1, GL_RGBA,
                       GL_UNSIGNED_BYTE, static_cast<GLsizei>(bytes.size()), bytes.data());
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  return bytes;
}

class RoomForMany : public testing::Test {
 protected:
  void expect_held(const std::vector<int>& numbers) {
    for (const int number : numbers) {
      ASSERT_TRUE(texture_.holds(key(number))) << number;
      EXPECT_TRUE(bytes_found(texture_, number) == marked_tile(number).bytes) << number;
    }
  }

  OffscreenContext context_;
  DrapeTexture texture_{grid_of_many(), RasterKind::kPhoto, kBudget};
};

TEST_F(RoomForMany, TakesItUpAsTilesCome) {
  EXPECT_EQ(texture_.capacity(), kRoom);
  EXPECT_EQ(texture_.allocated_bytes(), kAtFirst * kTileBytes);
  std::vector<int> all;
  for (int number = 0; number < static_cast<int>(kRoom); ++number) {
    all.push_back(number);
    const std::uint64_t before = texture_.allocated_bytes();
    ASSERT_TRUE(texture_.put(marked_tile(number), 1));
    if (texture_.allocated_bytes() != before) {
      EXPECT_LE(before + texture_.allocated_bytes(), kBudget) << "both while tiles were copied";
    }
    EXPECT_EQ(texture_.used_bytes(), all.size() * kTileBytes);
    EXPECT_LE(texture_.allocated_bytes(),
              std::max(kAtFirst * kTileBytes, 2 * texture_.used_bytes()));
    EXPECT_GE(texture_.allocated_bytes(), texture_.used_bytes());
  }
  EXPECT_EQ(texture_.allocated_bytes(), kRoom * kTileBytes);
  expect_held(all);
}

TEST_F(RoomForMany, HoldsNoMoreThanThat) {
  for (int number = 0; number < 100; ++number)
    ASSERT_TRUE(texture_.put(marked_tile(number), static_cast<std::uint64_t>(number)));
  EXPECT_EQ(texture_.allocated_bytes(), kRoom * kTileBytes);
  EXPECT_EQ(texture_.used_bytes(), kRoom * kTileBytes);
  for (int number = 0; number < 32; ++number) EXPECT_FALSE(texture_.holds(key(number)));
  expect_held({32, 33, 69, 70, 71, 98, 99});
  for (int number = 32; number < 100; ++number) texture_.use(key(number), 200);
  EXPECT_FALSE(texture_.put(marked_tile(100), 200)) << "all are in use";
}

TEST_F(RoomForMany, GivesItBackAndTakesItAgain) {
  for (int number = 0; number < 50; ++number) ASSERT_TRUE(texture_.put(marked_tile(number), 1));
  texture_.clear();
  EXPECT_EQ(texture_.used_bytes(), 0u);
  EXPECT_EQ(texture_.allocated_bytes(), kAtFirst * kTileBytes);
  EXPECT_TRUE(bytes_found(texture_, 20).empty()) << "the table still tells of what is gone";
  for (int number = 20; number < 60; ++number) ASSERT_TRUE(texture_.put(marked_tile(number), 2));
  expect_held({20, 28, 29, 45, 59});
}

TEST(DrapeTexture, OfFewTilesTakesUpNoMoreThanThose) {
  const OffscreenContext context;
  // 2 x 2 tiles and the one over them.
  DrapeTexture texture(make_grid(512, 512, 0.0, 512.0, 1.0, 1.0), RasterKind::kPhoto, 1u << 30);
  EXPECT_EQ(texture.capacity(), 5u);
  for (const TileKey tile :
       {TileKey{1, 0, 0}, TileKey{0, 0, 0}, TileKey{0, 1, 0}, TileKey{0, 0, 1}, TileKey{0, 1, 1}})
    ASSERT_TRUE(texture.put({tile, std::vector<std::uint8_t>(kTileBytes)}, 1));
  EXPECT_EQ(texture.allocated_bytes(), 5 * kTileBytes);
}

/// The process may take no more memory than it has. Mesa's rasteriser in software has none of its
/// own, so that is what the GPU has, too.
class NoMoreMemory {
 public:
  NoMoreMemory() {
    getrlimit(RLIMIT_AS, &before_);
    std::ifstream statm("/proc/self/statm");
    rlim_t pages = 0;
    statm >> pages;
    // Enough for a tile on its way, less than an array.
    rlimit limit = before_;
    limit.rlim_cur = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (4u << 20);
    setrlimit(RLIMIT_AS, &limit);
  }
  ~NoMoreMemory() { setrlimit(RLIMIT_AS, &before_); }

 private:
  rlimit before_{};
};

TEST(DrapeTexture, MakesDoWithTheRoomThatTheGpuHas) {
  const OffscreenContext context;
  const std::string renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  if (renderer.find("llvmpipe") == std::string::npos) GTEST_SKIP() << renderer;
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer ends programs that have no more memory";
#endif
  constexpr std::uint64_t kMany = 1500;
  // An array is more than what earlier tests may have left.
  const PyramidGrid grid = make_grid(16384, 16384, 0.0, 4096.0, 1.0, 1.0);
  DrapeTexture texture(grid, RasterKind::kPhoto, kMany * kTileBytes);
  const auto at_first = static_cast<int>(texture.allocated_bytes() / kTileBytes);
  for (int number = 0; number < at_first; ++number)
    ASSERT_TRUE(texture.put(marked_tile(number), 1)) << number;
  {
    const NoMoreMemory none;
    ASSERT_TRUE(texture.put(marked_tile(at_first), 2));
  }
  EXPECT_EQ(texture.capacity(), static_cast<std::size_t>(at_first));
  EXPECT_FALSE(texture.holds(key(0))) << "it made room";
  for (int number = 1; number <= at_first; number += 7)
    EXPECT_TRUE(bytes_found(texture, number) == marked_tile(number).bytes) << number;
}

TEST(DrapeTexture, RefusesABudgetThatOneViewDoesNotFit) {
  const OffscreenContext context;
  EXPECT_THROW(DrapeTexture(grid_of_many(), RasterKind::kPhoto, 95 * kTileBytes), RunError);
}

/// A photograph of 2048 x 2048 texels of 0.5 m, 64 tiles and the coarser ones.
std::filesystem::path write_photo(const test::TemporaryFolder& folder) {
  test::MadeRaster raster{2048, 2048, 3};
  raster.transform = {2600000.0, 0.5, 0.0, 1200000.0, 0.0, -0.5};
  test::make_tiff(folder / "photo.tif", raster,
                  [](int band, int column, int row) { return (column + 3 * row + band) % 256; });
  return folder / "photo.tif";
}

TEST(Drape, HiddenForLongGivesBackWhatItTookUpAndReadsItAgain) {
  const test::TemporaryFolder folder;
  const OffscreenContext context;
  Drape drape({write_photo(folder)}, RasterKind::kPhoto, "EPSG:2056", 200 * kTileBytes);
  const std::uint64_t at_first = drape.texture().allocated_bytes();
  EXPECT_LT(at_first, 25 * kTileBytes);
  TileView view;
  view.camera.eye = {2600250.0, 1199488.0, 800.0};
  view.camera.pitch_deg = -90.0;
  view.camera.field_of_view_deg = 40.0;
  view.height_pixels = 2000.0;
  ASSERT_TRUE(drape.settle(view, 1));
  const DrapeCounts shown = drape.counts();
  EXPECT_GT(shown.tiles_needed, 60u);
  EXPECT_GT(shown.allocated_bytes, 3 * at_first);

  constexpr double kFrame = 0.5;
  for (double hidden = kFrame; hidden < Drape::kHiddenSeconds; hidden += kFrame) drape.hide(kFrame);
  EXPECT_EQ(drape.texture().allocated_bytes(), shown.allocated_bytes) << "a short while";
  drape.update(view, {}, 2);
  for (double hidden = kFrame; hidden < Drape::kHiddenSeconds; hidden += kFrame) drape.hide(kFrame);
  EXPECT_EQ(drape.texture().allocated_bytes(), shown.allocated_bytes) << "it was seen meanwhile";
  drape.hide(kFrame);
  EXPECT_EQ(drape.texture().allocated_bytes(), at_first);
  EXPECT_EQ(drape.counts().used_bytes, 0u);

  ASSERT_TRUE(drape.settle(view, 3));
  EXPECT_EQ(drape.counts().used_bytes, shown.used_bytes);
  EXPECT_EQ(drape.counts().tiles_read, 2 * shown.tiles_read + 1) << "with the coarsest";
}

}  // namespace
}  // namespace cornice::viewer
