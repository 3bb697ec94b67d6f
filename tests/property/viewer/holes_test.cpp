// SPDX-License-Identifier: GPL-3.0-or-later
// Flights through a crater in front of magenta: whatever is loaded, no pixel of it is seen.
#include "tests/property/viewer/crater_fixture.h"
#include "tests/support/picture.h"

namespace cornice::viewer {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr double kErrorPixels = 1.59, kFrameSeconds = 1.0 / 30.0;

class Holes : public CraterFixture {};

/// Levels of the cells that are drawn, as bits.
std::uint32_t levels_of(Layer& layer) {
  std::uint32_t levels = 0;
  for (const std::uint32_t c : layer.chosen()) levels |= 1u << layer.tree().cells[c].key.level;
  return levels;
}

void fly_without_holes(CraterStudio& studio, int frames) {
  std::uint32_t levels = 0;
  std::size_t mixed = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const Camera camera = crater_camera(double(frame) / frames);
    // Now and then all is waited for, so that there is enough to see however slow loading is.
    if (frame % 8 == 0)
      studio.settle(camera, kErrorPixels);
    else
      studio.update(camera, kErrorPixels, kFrameSeconds);
    const std::uint32_t here = levels_of(studio.layer());
    levels |= here;
    mixed += (here & (here - 1)) != 0 ? 1 : 0;
    ASSERT_EQ(test::count_of(studio.draw(studio.layer().list(), camera), kMagenta), 0u)
        << "frame " << frame;
  }
  EXPECT_NE(levels & (levels - 1), 0u) << "one level alone was drawn";
  EXPECT_GT(mixed, static_cast<std::size_t>(frames) / 10) << "hardly any borders of levels";
}

TEST_F(Holes, AreNotSeenIn500FramesOverACliffAndBordersOfLevels) {
  CraterStudio studio(crater_file(), kWidth, kHeight, {});
  fly_without_holes(studio, 500);
}

TEST_F(Holes, AreNotSeenInAnOctree) {
  const test::TemporaryFolder folder;
  write_crater(folder / "octree.hlod", hlod::Partition::kOctree);
  CraterStudio studio(folder / "octree.hlod", kWidth, kHeight, {});
  fly_without_holes(studio, 120);
}

TEST_F(Holes, AreSeenWhereVerticesDoNotMorph) {
  CraterStudio studio(crater_file(), kWidth, kHeight, {});
  std::size_t holes = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const Camera camera = crater_camera(frame / 60.0);
    studio.settle(camera, 6.0);
    holes += test::count_of(studio.draw(without_morphing(studio.layer().list()), camera), kMagenta);
  }
  EXPECT_GT(holes, 0u) << "the flights above could not have seen a crack";
}

TEST_F(Holes, AreNotSeenWithRoomForATenthOfTheData) {
  const hlod::File whole(crater_file());
  CraterStudio::Budgets tenth;
  tenth.gpu_bytes = 0;
  for (const hlod::Node& node : whole.nodes())
    tenth.gpu_bytes += (node.vertices + (node.key.level > 0 ? node.parents : node.vertices)) *
                           kWordsPerVertex * 4 +
                       std::uint64_t{node.triangles} * 6;
  tenth.gpu_bytes /= 10;
  tenth.cache_bytes = tenth.gpu_bytes;
  CraterStudio studio(crater_file(), kWidth, kHeight, tenth);
  fly_without_holes(studio, 250);
  EXPECT_LE(studio.cells().allocated_bytes(), tenth.gpu_bytes);
  EXPECT_LE(studio.layer().counts().store.memory_bytes, tenth.cache_bytes);
  EXPECT_GT(studio.layer().counts().store.cells_read, studio.layer().file().nodes().size() / 8)
      << "little was read";
  // A view that would take far more is as fine as there is room for.
  const Camera near = crater_camera(0.1);
  EXPECT_TRUE(studio.settle(near, 0.0106));
  EXPECT_LT(studio.layer().counts().share, 1.0);
  EXPECT_GT(studio.layer().counts().cells, 8u);
  EXPECT_EQ(test::count_of(studio.draw(studio.layer().list(), near), kMagenta), 0u);
  EXPECT_TRUE(studio.layer().take_failures().empty());
}

}  // namespace
}  // namespace cornice::viewer
