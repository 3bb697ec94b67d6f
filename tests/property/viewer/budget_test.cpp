// SPDX-License-Identifier: GPL-3.0-or-later
// What budgets of memory and of a frame's time leave.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "tests/property/viewer/crater_fixture.h"
#include "tests/support/hierarchy.h"

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

/// What is drawn is what the file holds, word for word.
void expect_exact(const DrawList& list, const GpuCells& cells, CellStore& store) {
  std::vector<std::uint32_t> rows;
  for (const DrawList::Item& item : list.items) rows.push_back(item.row);
  store.want(rows);
  store.wait();
  for (const DrawList::Item& item : list.items) {
    const auto expected = store.find(item.row);
    ASSERT_TRUE(expected) << item.row;
    const GpuCell& at = item.cell;
    std::vector<std::uint32_t> words(at.stored_count * kWordsPerVertex);
    glGetNamedBufferSubData(cells.vertices(at.page),
                            static_cast<GLintptr>(PageSize{at.first_vertex, 0}.bytes()),
                            static_cast<GLsizeiptr>(words.size() * 4), words.data());
    ASSERT_TRUE(words == expected->words) << item.row;
    std::vector<std::uint16_t> indices(at.index_count);
    glGetNamedBufferSubData(cells.indices(at.page),
                            static_cast<GLintptr>(PageSize{0, at.first_index}.bytes()),
                            static_cast<GLsizeiptr>(indices.size() * 2), indices.data());
    ASSERT_TRUE(indices == expected->indices) << item.row;
  }
}

/// Cells of some hundred kilobytes come in parts of what a frame may take up, while the eye jumps
/// and others have to make room.
TEST_F(Budget, OfUploadsHoldsInEveryFrameWhateverTheSizeOfCells) {
  const test::TemporaryFolder folder;
  hlod::BuildOptions build;
  build.triangles_per_cell = 6000;
  test::write_hierarchy(folder / "large_cells.hlod", crater_mesh(), build);
  const hlod::File file(folder / "large_cells.hlod");
  std::uint64_t all = 0, largest = 0;
  for (const hlod::Node& node : file.nodes()) {
    all += packed_bytes(node);
    largest = std::max(largest, packed_bytes(node));
  }
  const OffscreenContext context;
  CellStore store(std::make_shared<const hlod::File>(folder / "large_cells.hlod"), {1, 256u << 20});
  for (const std::uint64_t limit : {std::uint64_t{0}, Layer::kLeastUpload, 3 * largest / 4}) {
    const std::uint64_t most = std::max(limit, Layer::kLeastUpload), gpu_bytes = all / 3;
    ASSERT_LT(most, largest) << "cells of a frame tell nothing";
    GpuCells cells(gpu_bytes, gpu_bytes);
    Layer layer(folder / "large_cells.hlod", 0, {1, 256u << 20}, cells);
    LayerView view;
    view.width = 160, view.height = 120;
    view.error_pixels = 1.0;
    view.seconds = 1.0 / 60.0;
    view.upload_bytes_per_s = 60.0 * static_cast<double>(limit);
    view.upload_time_share = limit == 0 ? 0.0 : 1.0;
    std::uint64_t frame = 1, at_most = 0, sum = 0;
    const auto fly = [&](double t) {
      view.camera = crater_camera(t);
      layer.update(view, cells, ++frame);
      at_most = std::max(at_most, layer.counts().uploaded_bytes);
      sum += layer.counts().uploaded_bytes;
      ASSERT_LE(layer.counts().uploaded_bytes, most) << "frame " << frame;
      ASSERT_LE(cells.allocated_bytes(), gpu_bytes);
      // The thread that reads gets ahead of the uploads.
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    // Twelve frames at a place are too few for what it takes.
    for (int jump = 0; jump < 60; ++jump)
      for (int stay = 0; stay < 12; ++stay) fly(0.13 * jump - std::floor(0.13 * jump));
    for (int stay = 0; stay < 2000 && (stay < 3 || layer.counts().cells_missing > 0); ++stay)
      fly(0.1);
    EXPECT_EQ(layer.counts().cells_missing, 0u);
    EXPECT_GE(at_most, Layer::kLeastUpload);
    EXPECT_GT(sum, gpu_bytes) << "nothing had to make room";
    expect_exact(layer.list(), cells, store);
  }
}

TEST_F(Budget, OfUploadsIsSpreadOverFramesWhereAllWouldFitIntoOne) {
  const test::TemporaryFolder folder;
  hlod::BuildOptions build;
  build.triangles_per_cell = 6000;
  test::write_hierarchy(folder / "large_cells.hlod", crater_mesh(), build);
  const OffscreenContext context;
  GpuCells cells(256u << 20);
  Layer layer(folder / "large_cells.hlod", 0, {1, 256u << 20}, cells);
  LayerView view;
  view.camera = crater_camera(0.1);
  view.width = 160, view.height = 120;
  view.error_pixels = 3.0;
  view.seconds = 1.0 / 60.0;
  view.upload_time_share = 1.0;
  std::uint64_t frame = 1, at_most = 0, sum = 0;
  do {
    layer.update(view, cells, ++frame);
    at_most = std::max(at_most, layer.counts().uploaded_bytes);
    sum += layer.counts().uploaded_bytes;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  } while (layer.counts().cells_missing > 0 && frame < 2000);
  EXPECT_EQ(layer.counts().cells_missing, 0u);
  EXPECT_LT(static_cast<double>(sum), view.upload_bytes_per_s * view.seconds);
  EXPECT_GT(sum, 10 * Layer::kLeastUpload);
  // A tenth of a second is six frames.
  EXPECT_LE(at_most, std::max(Layer::kLeastUpload, sum / 6 + 1));
}

}  // namespace
}  // namespace cornice::viewer
