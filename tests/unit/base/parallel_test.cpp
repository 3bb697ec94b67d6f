// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/parallel.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace cornice {
namespace {

std::set<std::pair<std::size_t, std::size_t>> ranges_of(std::size_t count, std::size_t grain,
                                                        int threads) {
  std::mutex mutex;
  std::set<std::pair<std::size_t, std::size_t>> ranges;
  parallel_for(count, grain, threads, [&](std::size_t begin, std::size_t end) {
    const std::lock_guard lock(mutex);
    EXPECT_TRUE(ranges.emplace(begin, end).second) << "a range came twice";
  });
  return ranges;
}

TEST(ParallelFor, VisitsEveryItemOnceWhateverTheSizes) {
  for (const std::size_t count : {0, 1, 2, 7, 1000, 4097}) {
    for (const std::size_t grain : {1, 2, 7, 64, 5000}) {
      for (const int threads : {0, 1, 2, 5}) {
        std::vector<std::atomic<int>> visits(count);
        parallel_for(count, grain, threads, [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) ++visits[i];
        });
        for (const auto& visit : visits) ASSERT_EQ(visit, 1);
      }
    }
  }
}

TEST(ParallelFor, CutsTheSameRangesForAnyNumberOfThreads) {
  const auto one = ranges_of(1003, 10, 1);
  EXPECT_EQ(one.size(), 101u);
  EXPECT_EQ(one.count({1000, 1003}), 1u);
  EXPECT_EQ(ranges_of(1003, 10, 2), one);
  EXPECT_EQ(ranges_of(1003, 10, 16), one);
}

TEST(ParallelFor, TakesAGrainOfZeroAsOne) { EXPECT_EQ(ranges_of(5, 0, 2).size(), 5u); }

TEST(ParallelFor, DoesNotOverflowNearTheLargestCount) {
  const std::size_t huge = std::numeric_limits<std::size_t>::max();
  EXPECT_EQ(ranges_of(huge, huge - 1, 2),
            (std::set<std::pair<std::size_t, std::size_t>>{{0, huge - 1}, {huge - 1, huge}}));
}

TEST(ParallelFor, RethrowsTheFirstFailureByRangeOrderNotByTime) {
  for (const int threads : {1, 2, 4}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      try {
        parallel_for(64, 1, threads, [](std::size_t begin, std::size_t) {
          // The earlier failure comes later in time.
          if (begin == 3) std::this_thread::sleep_for(std::chrono::milliseconds(1));
          if (begin == 3 || begin == 4 || begin == 50)
            throw std::runtime_error(std::to_string(begin));
        });
        FAIL() << "no failure came through";
      } catch (const std::runtime_error& error) {
        ASSERT_STREQ(error.what(), "3");
      }
    }
  }
}

TEST(ParallelFor, WaitsForRunningRangesBeforeItRethrows) {
  std::atomic<int> running{0};
  EXPECT_THROW(parallel_for(8, 1, 2,
                            [&](std::size_t begin, std::size_t) {
                              ++running;
                              std::this_thread::sleep_for(std::chrono::milliseconds(2));
                              --running;
                              if (begin == 0) throw std::runtime_error("first");
                            }),
               std::runtime_error);
  EXPECT_EQ(running, 0);
}

TEST(ParallelFor, MayNest) {
  std::atomic<int> visits{0};
  parallel_for(10, 1, 2, [&](std::size_t, std::size_t) {
    parallel_for(100, 7, 2, [&](std::size_t begin, std::size_t end) {
      visits += static_cast<int>(end - begin);
    });
  });
  EXPECT_EQ(visits, 1000);
}

TEST(ParallelFor, NeverUsesMoreThreadsThanAsked) {
  std::mutex mutex;
  std::set<std::thread::id> threads;
  parallel_for(200, 1, 2, [&](std::size_t, std::size_t) {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  });
  EXPECT_LE(threads.size(), 2u);
}

TEST(ParallelReduce, GivesTheSameBitsForAnyNumberOfThreads) {
  // Terms of such different size that the sum depends on the order of additions.
  const auto sum = [](int threads) {
    return parallel_reduce(
        100000, 64, threads, 0.0,
        [](std::size_t begin, std::size_t end) {
          double part = 0.0;
          for (std::size_t i = begin; i < end; ++i) {
            part += std::sin(static_cast<double>(i)) * std::pow(10.0, static_cast<double>(i % 17));
          }
          return part;
        },
        [](double& total, double part) { total += part; });
  };
  const double one = sum(1);
  for (int repeat = 0; repeat < 5; ++repeat) {
    EXPECT_EQ(sum(2), one);
    EXPECT_EQ(sum(7), one);
  }
}

TEST(ParallelReduce, OfNothingIsTheInitialValue) {
  EXPECT_EQ(parallel_reduce(
                0, 8, 2, 42, [](std::size_t, std::size_t) { return 1; },
                [](int& total, int part) { total += part; }),
            42);
}

TEST(ThreadCount, IsTheAffinityMasksWhereZeroIsAsked) {
  cpu_set_t before;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  EXPECT_EQ(thread_count(0), CPU_COUNT(&before));
  cpu_set_t one;
  CPU_ZERO(&one);
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &before) && CPU_COUNT(&one) == 0) CPU_SET(cpu, &one);
  }
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(thread_count(0), 1);
  EXPECT_EQ(thread_count(3), 3);
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

}  // namespace
}  // namespace cornice
