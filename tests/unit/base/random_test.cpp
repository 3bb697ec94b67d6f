// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cornice {
namespace {

TEST(CounterRandom, IsAFunctionOfSeedStreamAndItemAlone) {
  CounterRandom a(1, 2, 3);
  CounterRandom b(1, 2, 3);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(a.bits(), b.bits());
  EXPECT_NE(CounterRandom(1, 2, 3).bits(), CounterRandom(1, 2, 4).bits());
  EXPECT_NE(CounterRandom(1, 2, 3).bits(), CounterRandom(1, 3, 3).bits());
  EXPECT_NE(CounterRandom(1, 2, 3).bits(), CounterRandom(2, 2, 3).bits());
}

TEST(CounterRandom, UniformStaysInItsIntervalAndFillsIt) {
  double sum = 0.0;
  double least = 1.0;
  double most = 0.0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double u = CounterRandom(7, 0, static_cast<std::uint64_t>(i)).uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    least = std::min(least, u);
    most = std::max(most, u);
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 4.0 * std::sqrt(1.0 / 12.0 / kDraws));
  EXPECT_LT(least, 1e-3);
  EXPECT_GT(most, 1.0 - 1e-3);
}

TEST(CounterRandom, NormalHasMeanZeroAndDeviationOne) {
  constexpr int kDraws = 200000;
  double sum = 0.0;
  double squares = 0.0;
  int beyond_three = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = CounterRandom(3, 1, static_cast<std::uint64_t>(i)).normal();
    sum += x;
    squares += x * x;
    if (std::abs(x) > 3.0) ++beyond_three;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 4.0 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0, 4.0 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(beyond_three, 0.0027 * kDraws, 100.0);
}

TEST(CounterRandom, NeighbouringItemsAreNotCorrelated) {
  constexpr int kDraws = 100000;
  double product = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double a = CounterRandom(5, 0, static_cast<std::uint64_t>(i)).uniform() - 0.5;
    const double b = CounterRandom(5, 0, static_cast<std::uint64_t>(i) + 1).uniform() - 0.5;
    product += 12.0 * a * b;
  }
  EXPECT_NEAR(product / kDraws, 0.0, 4.0 / std::sqrt(kDraws));
}

}  // namespace
}  // namespace cornice
