// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"

namespace cornice {
namespace {

struct Item {
  std::uint64_t key = 0;
  std::size_t place = 0;
  bool operator==(const Item&) const = default;
};

std::vector<Item> random_items(std::size_t count, std::uint64_t mask) {
  std::vector<Item> items(count);
  CounterRandom random(1, 2, 3);
  for (std::size_t i = 0; i < count; ++i) items[i] = {random.bits() & mask, i};
  return items;
}

std::vector<Item> sorted_by_bits(std::vector<Item> items, int first_bit, int last_bit) {
  const std::uint64_t mask = last_bit - first_bit == 64
                                 ? ~std::uint64_t{0}
                                 : (std::uint64_t{1} << (last_bit - first_bit)) - 1;
  std::stable_sort(items.begin(), items.end(), [&](const Item& a, const Item& b) {
    return (a.key >> first_bit & mask) < (b.key >> first_bit & mask);
  });
  return items;
}

constexpr auto kKey = [](const Item& item) { return item.key; };

TEST(RadixSort, OrdersLikeAStableSortByTheSameBits) {
  for (const auto& [first_bit, last_bit] : {std::pair{0, 64}, {0, 48}, {7, 8}, {3, 40}, {60, 64}}) {
    for (const std::size_t count : {0, 1, 2, 1000}) {
      std::vector<Item> items = random_items(count, ~std::uint64_t{0});
      const std::vector<Item> expected = sorted_by_bits(items, first_bit, last_bit);
      radix_sort(items, first_bit, last_bit, 2, kKey);
      EXPECT_EQ(items, expected) << first_bit << ".." << last_bit << ", " << count;
    }
  }
}

TEST(RadixSort, KeepsTheOrderOfItemsThatAgree) {
  std::vector<Item> items = random_items(5000, 0xff00f);
  const std::vector<Item> expected = sorted_by_bits(items, 0, 64);
  radix_sort(items, 0, 64, 1, kKey);
  EXPECT_EQ(items, expected);
}

TEST(RadixSort, IsTheSameWithOneThreadAndTwoOverSeveralChunks) {
  std::vector<Item> one = random_items((std::size_t{1} << 21) + 12345, 0xffffff);
  std::vector<Item> two = one;
  radix_sort(one, 0, 24, 1, kKey);
  radix_sort(two, 0, 24, 2, kKey);
  EXPECT_TRUE(one == two);
  EXPECT_TRUE(std::is_sorted(one.begin(), one.end(), [](const Item& a, const Item& b) {
    return a.key != b.key ? a.key < b.key : a.place < b.place;
  }));
}

}  // namespace
}  // namespace cornice
