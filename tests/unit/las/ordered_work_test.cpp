// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/ordered_work.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace cornice::test {
namespace {

/// Squares of 0 ... count - 1 through slots.
struct Squares {
  explicit Squares(std::size_t count, int threads) : slots(ordered_slots(threads)) {
    work.count = count;
    work.threads = threads;
    work.fetch = [this](std::size_t i, std::size_t s) {
      fetched.push_back(i);
      slots[s] = i;
    };
    work.work = [this](std::size_t, std::size_t s) { slots[s] *= slots[s]; };
    work.deliver = [this](std::size_t, std::size_t s) {
      delivered.push_back(slots[s]);
      return true;
    };
  }
  OrderedWork work;
  std::vector<std::size_t> slots;
  std::vector<std::size_t> fetched;
  std::vector<std::size_t> delivered;
};

std::vector<std::size_t> squares(std::size_t count) {
  std::vector<std::size_t> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = i * i;
  return values;
}

TEST(OrderedWork, ItemsAreFetchedAndDeliveredInOrderWithAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 3, 8}) {
    for (const std::size_t count : {0u, 1u, 2u, 5u, 500u}) {
      Squares run(count, threads);
      run_ordered(run.work);
      EXPECT_EQ(run.delivered, squares(count)) << threads;
      std::vector<std::size_t> in_order(count);
      std::iota(in_order.begin(), in_order.end(), std::size_t{0});
      EXPECT_EQ(run.fetched, in_order) << threads;
    }
  }
}

TEST(OrderedWork, TheFirstErrorInOrderIsTheOneThatIsSeen) {
  for (const int threads : {1, 2, 4}) {
    Squares run(100, threads);
    const auto work = run.work.work;
    run.work.work = [&](std::size_t i, std::size_t s) {
      if (i == 30 || i == 31 || i == 33) throw std::runtime_error(std::to_string(i));
      work(i, s);
    };
    try {
      run_ordered(run.work);
      ADD_FAILURE() << "no error";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "30");
    }
    EXPECT_EQ(run.delivered, squares(30));
  }
}

TEST(OrderedWork, AnErrorWhileFetchingOrDeliveringEndsTheRun) {
  for (const int threads : {1, 3}) {
    Squares fetching(50, threads);
    fetching.work.fetch = [](std::size_t i, std::size_t) {
      if (i == 7) throw std::runtime_error("fetch");
    };
    EXPECT_THROW(run_ordered(fetching.work), std::runtime_error);
    EXPECT_EQ(fetching.delivered.size(), 7u);
    Squares delivering(50, threads);
    delivering.work.deliver = [](std::size_t i, std::size_t) -> bool {
      if (i == 9) throw std::runtime_error("deliver");
      return true;
    };
    EXPECT_THROW(run_ordered(delivering.work), std::runtime_error);
  }
}

TEST(OrderedWork, ADeliveryThatSaysNoEndsTheRun) {
  for (const int threads : {1, 2}) {
    Squares run(1000, threads);
    const auto deliver = run.work.deliver;
    run.work.deliver = [&](std::size_t i, std::size_t s) { return deliver(i, s) && i < 4; };
    run_ordered(run.work);
    EXPECT_EQ(run.delivered, squares(5));
  }
}

TEST(OrderedWork, NoMoreItemsAreUnderWayThanThereAreSlots) {
  Squares run(200, 3);
  std::atomic<std::size_t> under_way{0};
  std::atomic<std::size_t> most{0};
  const auto fetch = run.work.fetch;
  const auto deliver = run.work.deliver;
  run.work.fetch = [&](std::size_t i, std::size_t s) {
    const std::size_t now = ++under_way;
    if (now > most) most = now;
    fetch(i, s);
  };
  run.work.deliver = [&](std::size_t i, std::size_t s) {
    --under_way;
    return deliver(i, s);
  };
  run_ordered(run.work);
  EXPECT_LE(most, ordered_slots(3));
  EXPECT_EQ(run.delivered.size(), 200u);
}

}  // namespace
}  // namespace cornice::test
