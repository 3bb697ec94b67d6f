// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/parallel.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

#include "core/base/workers.h"

namespace cornice {
namespace {

int cores_of_affinity_mask() {
  // Machines may have more cores than a fixed cpu_set_t has bits: grow until the kernel agrees.
  for (int bits = 1024; bits <= (1 << 20); bits *= 2) {
    cpu_set_t* mask = CPU_ALLOC(bits);
    if (mask == nullptr) break;
    const std::size_t bytes = CPU_ALLOC_SIZE(bits);
    const bool known = sched_getaffinity(0, bytes, mask) == 0;
    const int cores = known ? CPU_COUNT_S(bytes, mask) : 0;
    CPU_FREE(mask);
    if (cores > 0) return cores;
  }
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Ranges handed out in order to whichever thread asks next.
class Ranges {
 public:
  using Body = std::function<void(std::size_t, std::size_t)>;
  Ranges(std::size_t count, std::size_t grain, const Body& body)
      : count_(count), grain_(grain), ranges_((count - 1) / grain + 1), body_(body) {}

  std::size_t size() const { return ranges_; }

  /// Runs ranges until none is left. A range behind one that has failed is skipped, one before it
  /// still runs: so the failure that is kept does not depend on timing.
  void work() {
    for (std::size_t i = next_++; i < ranges_; i = next_++) {
      if (i > failed_) continue;
      try {
        const std::size_t begin = i * grain_;
        body_(begin, begin + std::min(grain_, count_ - begin));
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (i < failed_) {
          failed_ = i;
          failure_ = std::current_exception();
        }
      }
    }
  }

  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  const std::size_t count_;
  const std::size_t grain_;
  const std::size_t ranges_;
  const Body& body_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> failed_{std::numeric_limits<std::size_t>::max()};
  std::mutex mutex_;
  std::exception_ptr failure_;
};

}  // namespace

int thread_count(int threads_option) {
  assert(threads_option >= 0 && "a number of threads is 0 or more");
  return threads_option > 0 ? threads_option : cores_of_affinity_mask();
}

void parallel_for(std::size_t count, std::size_t grain, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& body) {
  if (count == 0) return;
  Ranges ranges(count, std::max<std::size_t>(grain, 1), body);
  // More threads than cores gain nothing, and TBB warns of them on stderr.
  const int useful = std::min(thread_count(threads), cores_of_affinity_mask());
  const std::size_t workers = std::min(ranges.size(), static_cast<std::size_t>(useful));
  if (workers == 1) {
    ranges.work();
  } else {
    run_on_workers(workers, [&] { ranges.work(); });
  }
  ranges.rethrow();
}

}  // namespace cornice
