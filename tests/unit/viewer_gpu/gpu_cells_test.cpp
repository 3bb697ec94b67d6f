// SPDX-License-Identifier: GPL-3.0-or-later
// What stays on the GPU where not all has room.
#include "terrain-viewer/render/gpu_cells.h"

#include <gtest/gtest.h>

#include <vector>

#include "terrain-viewer/render/offscreen_context.h"

namespace cornice::viewer {
namespace {

constexpr std::size_t kStored = 100, kIndices = 300;
constexpr std::uint64_t kCellBytes = kStored * kWordsPerVertex * 4 + kIndices * 2;

/// A cell of which every word and index says which it is.
PackedCell marked_cell(std::uint32_t mark) {
  PackedCell cell;
  cell.node = mark;
  cell.vertex_count = kStored / 2;
  cell.words.assign(kStored * kWordsPerVertex, mark);
  cell.indices.assign(kIndices, static_cast<std::uint16_t>(mark));
  return cell;
}

/// Room for four cells; twenty are expected.
class FourCells : public testing::Test {
 protected:
  FourCells() { cells_.expect(20 * kStored, 20 * kIndices); }
  bool put(std::uint32_t row, std::uint64_t frame) {
    dropped_.clear();
    return cells_.put({0, row}, marked_cell(row), frame, dropped_);
  }
  std::vector<std::uint32_t> dropped() const {
    std::vector<std::uint32_t> rows;
    for (const CellId id : dropped_) rows.push_back(id.row);
    return rows;
  }

  OffscreenContext context_;
  GpuCells cells_{4 * kCellBytes};
  std::vector<CellId> dropped_;
};

TEST_F(FourCells, TheOneLongestUnusedMakesRoom) {
  for (const std::uint32_t row : {0u, 1u, 2u, 3u}) ASSERT_TRUE(put(row, 1)) << row;
  EXPECT_TRUE(dropped().empty());
  ASSERT_TRUE(cells_.use({0, 0}, 2));
  ASSERT_TRUE(cells_.use({0, 2}, 2));
  ASSERT_TRUE(put(4, 3));
  EXPECT_EQ(dropped(), std::vector<std::uint32_t>{1});
  ASSERT_TRUE(put(5, 3));
  EXPECT_EQ(dropped(), std::vector<std::uint32_t>{3});
  ASSERT_TRUE(put(6, 4));
  EXPECT_EQ(dropped(), std::vector<std::uint32_t>{0});
  EXPECT_FALSE(cells_.holds({0, 0}));
  EXPECT_TRUE(cells_.holds({0, 2}));
  EXPECT_LE(cells_.allocated_bytes(), 4 * kCellBytes);
}

TEST_F(FourCells, WhatThisFrameUsesStaysWhateverElseIsToBePut) {
  for (const std::uint32_t row : {0u, 1u, 2u, 3u}) {
    ASSERT_TRUE(put(row, 1));
    ASSERT_TRUE(cells_.use({0, row}, 7));
  }
  EXPECT_FALSE(put(4, 7));
  EXPECT_TRUE(dropped().empty());
  for (const std::uint32_t row : {0u, 1u, 2u, 3u}) EXPECT_TRUE(cells_.holds({0, row}));
  EXPECT_EQ(cells_.used_bytes(), 4 * kCellBytes);
  EXPECT_TRUE(put(4, 8)) << "a frame later they have had their time";
}

TEST_F(FourCells, HoldWhatWasPutAfterOthersMadeRoom) {
  for (std::uint32_t row = 0; row < 20; ++row) ASSERT_TRUE(put(row, row + 1));
  std::size_t held = 0;
  for (std::uint32_t row = 0; row < 20; ++row) {
    const auto cell = cells_.use({0, row}, 30);
    if (!cell) continue;
    ++held;
    std::vector<std::uint32_t> words(kStored * kWordsPerVertex);
    glGetNamedBufferSubData(cells_.vertices(),
                            static_cast<GLintptr>(cell->first_vertex * kWordsPerVertex * 4),
                            static_cast<GLsizeiptr>(words.size() * 4), words.data());
    EXPECT_EQ(words, marked_cell(row).words);
    std::vector<std::uint16_t> indices(kIndices);
    glGetNamedBufferSubData(cells_.indices(), static_cast<GLintptr>(cell->first_index * 2),
                            static_cast<GLsizeiptr>(indices.size() * 2), indices.data());
    EXPECT_EQ(indices, marked_cell(row).indices);
  }
  EXPECT_EQ(held, 4u);
}

}  // namespace
}  // namespace cornice::viewer
