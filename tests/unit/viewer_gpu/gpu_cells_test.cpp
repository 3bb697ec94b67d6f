// SPDX-License-Identifier: GPL-3.0-or-later
// What stays on the GPU where not all has room.
#include "terrain-viewer/render/gpu_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "terrain-viewer/render/offscreen_context.h"
#include "tests/unit/viewer_gpu/put_whole.h"

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
  FourCells() {
    for (int cell = 0; cell < 20; ++cell) cells_.expect(kStored, kIndices);
  }
  bool put(std::uint32_t row, std::uint64_t frame) {
    dropped_.clear();
    return put_whole(cells_, {0, row}, marked_cell(row), frame, dropped_);
  }
  std::vector<std::uint32_t> dropped() const {
    std::vector<std::uint32_t> rows;
    for (const CellId id : dropped_) rows.push_back(id.row);
    return rows;
  }

  void expect_marked(std::uint32_t row) {
    const auto cell = cells_.use({0, row}, 30);
    ASSERT_TRUE(cell) << row;
    std::vector<std::uint32_t> words(kStored * kWordsPerVertex);
    glGetNamedBufferSubData(cells_.vertices(cell->page),
                            static_cast<GLintptr>(cell->first_vertex * kWordsPerVertex * 4),
                            static_cast<GLsizeiptr>(words.size() * 4), words.data());
    EXPECT_EQ(words, marked_cell(row).words);
    std::vector<std::uint16_t> indices(kIndices);
    glGetNamedBufferSubData(cells_.indices(cell->page),
                            static_cast<GLintptr>(cell->first_index * 2),
                            static_cast<GLsizeiptr>(indices.size() * 2), indices.data());
    EXPECT_EQ(indices, marked_cell(row).indices);
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
    if (!cells_.holds({0, row})) continue;
    ++held;
    expect_marked(row);
  }
  EXPECT_EQ(held, 4u);
}

TEST_F(FourCells, AreThereOnceTheyAreWholeHoweverManyPartsTheyComeIn) {
  // Parts that end within a word, at the end of the vertices and within the indices.
  for (const std::uint64_t part :
       {std::uint64_t{1001}, std::uint64_t{kStored * kWordsPerVertex * 4}, std::uint64_t{2900},
        kCellBytes}) {
    const auto row = static_cast<std::uint32_t>(part % 19);
    std::uint64_t sum = 0;
    for (std::uint64_t frame = 1; sum < kCellBytes; ++frame) {
      EXPECT_FALSE(cells_.holds({0, row}));
      EXPECT_FALSE(cells_.use({0, row}, frame));
      const std::uint64_t bytes =
          cells_.put_part({0, row}, marked_cell(row), part, frame, dropped_, Growth::kSoon);
      ASSERT_EQ(bytes, std::min(part, kCellBytes - sum));
      sum += bytes;
    }
    EXPECT_TRUE(cells_.holds({0, row}));
    EXPECT_EQ(cells_.put_part({0, row}, marked_cell(row), part, 9, dropped_, Growth::kSoon), 0u);
    expect_marked(row);
  }
  EXPECT_TRUE(dropped_.empty());
  EXPECT_EQ(cells_.used_bytes(), 4 * kCellBytes);
}

TEST_F(FourCells, ThatMakeRoomHalfWayLeaveNothingBehind) {
  ASSERT_EQ(cells_.put_part({0, 7}, marked_cell(7), 2000, 1, dropped_, Growth::kSoon), 2000u);
  for (const std::uint32_t row : {0u, 1u, 2u}) ASSERT_TRUE(put(row, 2)) << row;
  ASSERT_TRUE(put(3, 2));
  EXPECT_EQ(dropped(), std::vector<std::uint32_t>{7});
  EXPECT_EQ(cells_.used_bytes(), 4 * kCellBytes);
  for (const std::uint32_t row : {0u, 1u, 2u, 3u}) expect_marked(row);
  dropped_.clear();
  EXPECT_EQ(cells_.put_part({0, 7}, marked_cell(7), 2000, 30, dropped_, Growth::kSoon), 0u);
  ASSERT_EQ(cells_.put_part({0, 7}, marked_cell(7), 2000, 31, dropped_, Growth::kSoon), 2000u)
      << "not what was left of it";
  EXPECT_FALSE(cells_.holds({0, 7}));
  ASSERT_EQ(cells_.put_part({0, 7}, marked_cell(7), kCellBytes, 31, dropped_, Growth::kSoon),
            kCellBytes - 2000);
  expect_marked(7);
}

TEST_F(FourCells, ThatAreOnTheirWayAndInUseStay) {
  ASSERT_EQ(cells_.put_part({0, 7}, marked_cell(7), 2000, 1, dropped_, Growth::kSoon), 2000u);
  for (const std::uint32_t row : {0u, 1u, 2u}) ASSERT_TRUE(put(row, 2)) << row;
  cells_.use({0, 7}, 3);
  ASSERT_TRUE(put(3, 3));
  EXPECT_EQ(dropped(), std::vector<std::uint32_t>{0});
}

/// Room for a hundred cells on pages of ten.
class Pages : public testing::Test {
 protected:
  static constexpr std::uint32_t kCells = 100;
  static constexpr std::uint64_t kPageBytes = 10 * kCellBytes;

  Pages() {
    for (std::uint32_t cell = 0; cell < kCells; ++cell) cells_.expect(kStored, kIndices);
  }
  bool put(std::uint32_t row, std::uint64_t frame) {
    return put_whole(cells_, {0, row}, marked_cell(row), frame, dropped_, Growth::kSoon);
  }
  /// Puts all that is not there in frame after frame until all are; returns the number of frames.
  std::uint64_t fly() {
    std::uint64_t frame = 0, waited_for = 0;
    for (std::uint32_t there = 0; there < kCells;) {
      ++frame;
      there = 0;
      for (std::uint32_t row = 0; row < kCells; ++row) there += put(row, frame) ? 1 : 0;
      EXPECT_LE(cells_.waited_for_bytes() - waited_for, kPageBytes) << "frame " << frame;
      EXPECT_LE(cells_.allocated_bytes(), kCells * kCellBytes);
      waited_for = cells_.waited_for_bytes();
    }
    return frame;
  }
  void expect_all_marked() {
    for (std::uint32_t row = 0; row < kCells; ++row) {
      const auto cell = cells_.use({0, row}, 1000);
      ASSERT_TRUE(cell) << row;
      std::vector<std::uint32_t> words(kStored * kWordsPerVertex);
      glGetNamedBufferSubData(cells_.vertices(cell->page),
                              static_cast<GLintptr>(cell->first_vertex * kWordsPerVertex * 4),
                              static_cast<GLsizeiptr>(words.size() * 4), words.data());
      EXPECT_EQ(words, marked_cell(row).words) << row;
    }
  }

  OffscreenContext context_;
  GpuCells cells_{kCells * kCellBytes, kPageBytes};
  std::vector<CellId> dropped_;
};

TEST_F(Pages, AreMadeOneAFrameByTheThreadThatDraws) {
  EXPECT_EQ(fly(), 10u);
  EXPECT_EQ(cells_.page_count(), 10u);
  EXPECT_EQ(cells_.waited_for_bytes(), kCells * kCellBytes);
  EXPECT_TRUE(dropped_.empty());
  expect_all_marked();
}

TEST_F(Pages, AreAllMadeAtOnceForAPicture) {
  for (std::uint32_t row = 0; row < kCells; ++row)
    ASSERT_TRUE(put_whole(cells_, {0, row}, marked_cell(row), 1, dropped_, Growth::kAtOnce));
  EXPECT_EQ(cells_.page_count(), 10u);
}

TEST_F(Pages, AreNotWaitedForWhereAnotherContextMakesThem) {
  auto second = context_.second();
  if (!second) GTEST_SKIP() << "the driver has no second context";
  cells_.make_ahead(std::move(second));
  fly();
  EXPECT_EQ(cells_.waited_for_bytes(), 0u);
  EXPECT_EQ(cells_.page_count(), 10u);
  EXPECT_TRUE(dropped_.empty());
  expect_all_marked();
}

TEST_F(Pages, AreMadeByTheThreadThatDrawsWhereTheOtherContextFails) {
  class Refused : public SecondContext {
   public:
    bool make_current() override { return false; }
    void release() override { ADD_FAILURE() << "of what was never had"; }
  };
  cells_.make_ahead(std::make_unique<Refused>());
  EXPECT_GE(fly(), 10u);
  EXPECT_EQ(cells_.page_count(), 10u);
  expect_all_marked();
}

TEST_F(Pages, GiveRoomToWhatComesOnceNoneCanBeMade) {
  fly();
  EXPECT_TRUE(put(kCells, 2000));
  EXPECT_EQ(dropped_.size(), 1u);
  EXPECT_EQ(cells_.page_count(), 10u);
}

}  // namespace
}  // namespace cornice::viewer
