// SPDX-License-Identifier: GPL-3.0-or-later
// What budgets of memory and of a frame's time leave.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "tests/property/viewer/crater_fixture.h"

namespace cornice::viewer {
namespace {

constexpr double kErrorPixels = 2.12;

class Budget : public CraterFixture {};

std::uint64_t packed_bytes(const hlod::Node& node) {
  return (node.vertices + (node.key.level > 0 ? node.parents : node.vertices)) * kWordsPerVertex *
             4 +
         std::uint64_t{node.triangles} * 6;
}

TEST_F(Budget, OfATenthHoldsTwoNeighbouringViewsAndLetsGoOfThemForOthersAlone) {
  CraterStudio::Budgets tenth{0, 0, 1};
  const hlod::File file(crater_file());
  for (const hlod::Node& node : file.nodes()) tenth.gpu_bytes += packed_bytes(node);
  tenth.gpu_bytes /= 10;
  tenth.cache_bytes = tenth.gpu_bytes;
  CraterStudio studio(crater_file(), 160, 120, tenth);
  const auto read_for = [&](double t) {
    const std::uint64_t before = studio.layer().counts().store.cells_read;
    EXPECT_TRUE(studio.settle(crater_camera(t), kErrorPixels));
    return studio.layer().counts().store.cells_read - before;
  };
  read_for(0.1), read_for(0.11);
  std::uint64_t again = 0;
  for (int swing = 0; swing < 5; ++swing) again += read_for(0.1) + read_for(0.11);
  EXPECT_EQ(again, 0u) << "cells come and go as the eye swings to and fro";
  std::uint64_t elsewhere = 0;
  for (int step = 1; step < 11; ++step) elsewhere += read_for(0.1 + 0.05 * step);
  EXPECT_GT(elsewhere, 0u);
  EXPECT_GT(studio.layer().counts().store.cells_read, studio.layer().counts().cells_loaded)
      << "all had room, nothing was tried";
  EXPECT_LE(studio.cells().allocated_bytes(), tenth.gpu_bytes);
}

/// Flies over two layers at once, a quadtree and an octree, with room for a tenth of both, faster
/// than is read: a frame takes what it gets.
TEST_F(Budget, OfATenthHoldsInEveryFrameOfAFlightOverTwoLayers) {
  const test::TemporaryFolder folder;
  write_crater(folder / "octree.hlod", hlod::Partition::kOctree);
  const std::vector<std::filesystem::path> files{crater_file(), folder / "octree.hlod"};
  std::uint64_t all = 0, largest = 0;
  for (const auto& path : files) {
    const hlod::File file(path);
    for (const hlod::Node& node : file.nodes()) {
      all += packed_bytes(node);
      largest = std::max(largest, packed_bytes(node));
    }
  }
  const std::uint64_t gpu_bytes = all / 10, cache_bytes = all / 20;
  const OffscreenContext context;
  GpuCells cells(gpu_bytes, gpu_bytes / 16);
  std::vector<std::unique_ptr<Layer>> layers;
  for (std::uint32_t i = 0; i < files.size(); ++i)
    layers.push_back(std::make_unique<Layer>(files[i], i, CellStoreOptions{1, cache_bytes}, cells));
  std::uint64_t most_gpu = 0, most_cache = 0;
  for (std::uint64_t frame = 1; frame <= 400; ++frame) {
    LayerView view;
    view.camera = crater_camera(static_cast<double>(frame) / 400.0);
    view.width = 160, view.height = 120;
    view.error_pixels = 0.5;
    view.seconds = 1.0 / 60.0;
    for (const auto& layer : layers) {
      layer->update(view, cells, frame);
      most_cache = std::max(most_cache, layer->counts().store.memory_bytes);
    }
    most_gpu = std::max(most_gpu, cells.allocated_bytes());
  }
  EXPECT_LE(most_gpu, gpu_bytes);
  EXPECT_LE(static_cast<double>(most_cache), 1.05 * static_cast<double>(cache_bytes));
  EXPECT_GT(static_cast<double>(most_gpu), 0.5 * static_cast<double>(gpu_bytes)) << "hardly used";
  EXPECT_GT(static_cast<double>(most_cache), 0.5 * static_cast<double>(cache_bytes));
  EXPECT_LT(5 * largest, cache_bytes) << "a budget of a few cells tells nothing";
}

/// Of three views with room for all, and on how many pages that was.
std::vector<Picture> pictures_of(const std::filesystem::path& file,
                                 const CraterStudio::Budgets& budgets, std::size_t& pages) {
  CraterStudio studio(file, 160, 120, budgets);
  std::vector<Picture> pictures;
  for (const double t : {0.1, 0.4, 0.7}) {
    EXPECT_TRUE(studio.settle(crater_camera(t), 0.3)) << t;
    pictures.push_back(studio.draw(studio.layer().list(), crater_camera(t)));
  }
  pages = studio.cells().page_count();
  return pictures;
}

TEST_F(Budget, OnManyPagesDrawsThePicturesOfOnePage) {
  CraterStudio::Budgets many;
  many.gpu_bytes = 9u << 20;
  many.page_bytes = many.gpu_bytes / 16;
  std::size_t pages = 0;
  const std::vector<Picture> expected = pictures_of(crater_file(), {}, pages);
  EXPECT_EQ(pages, 1u);
  const std::vector<Picture> pictures = pictures_of(crater_file(), many, pages);
  EXPECT_GT(pages, 4u);
  for (std::size_t i = 0; i < pictures.size(); ++i)
    EXPECT_TRUE(pictures[i].pixels == expected[i].pixels) << i;
}

TEST_F(Budget, OfNoTimeTakesOneCellAFrameToTheGpuUntilAllAreThere) {
  const OffscreenContext context;
  GpuCells cells(256u << 20);
  Layer layer(crater_file(), 0, {1, 256u << 20}, cells);
  std::set<std::uint64_t> sizes{0};
  for (const hlod::TreeCell& cell : layer.tree().cells) {
    std::uint64_t bytes = 0;
    for (std::uint32_t part = 0; part < cell.parts; ++part)
      bytes += packed_bytes(layer.file().nodes()[cell.first_node + part]);
    sizes.insert(bytes);
  }
  LayerView view;
  view.camera = crater_camera(0.1);
  view.width = 160, view.height = 120;
  view.error_pixels = 1.0;
  view.seconds = 1.0 / 60.0;
  view.upload_time_share = 0.0;
  std::uint64_t frame = 1, uploads = 0;
  do {
    layer.update(view, cells, ++frame);
    ASSERT_TRUE(sizes.contains(layer.counts().uploaded_bytes)) << "frame " << frame;
    uploads += layer.counts().uploaded_bytes > 0 ? 1 : 0;
    // The thread that reads gets ahead of the uploads.
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  } while (layer.counts().cells_missing > 0);
  EXPECT_GT(uploads, 20u);
}

}  // namespace
}  // namespace cornice::viewer
