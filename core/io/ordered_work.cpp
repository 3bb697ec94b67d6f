// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/ordered_work.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/parallel.h"

namespace cornice {
namespace {

void run_here(const OrderedWork& work) {
  for (std::size_t i = 0; i < work.count; ++i) {
    work.fetch(i, 0);
    work.work(i, 0);
    if (!work.deliver(i, 0)) return;
  }
}

/// Items next_ - slots ... next_ - 1 are between fetch and deliver.
class Pipeline {
 public:
  Pipeline(const OrderedWork& work, std::size_t slots) : work_(work), slots_(slots) {}

  void run(int threads) {
    std::vector<std::thread> workers;
    try {
      for (int t = 0; t < threads; ++t) workers.emplace_back([this] { work_on_items(); });
      deliver_items();
    } catch (...) {
      stop(workers);
      throw;
    }
    stop(workers);
  }

 private:
  struct Slot {
    bool ready = false;
    std::exception_ptr error;
  };

  void stop(std::vector<std::thread>& workers) {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    for (std::thread& worker : workers) worker.join();
  }

  void deliver_items() {
    for (std::size_t i = 0; i < work_.count; ++i) {
      Slot& slot = slots_[i % slots_.size()];
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return slot.ready; });
      }
      if (slot.error) std::rethrow_exception(slot.error);
      if (!work_.deliver(i, i % slots_.size())) return;
      {
        const std::lock_guard lock(mutex_);
        slot.ready = false;
        ++delivered_;
      }
      changed_.notify_all();
    }
  }

  void work_on_items() {
    while (true) {
      std::size_t i = 0;
      std::exception_ptr error;
      {
        // Held while fetching, so that inputs are read in order.
        const std::lock_guard in_order(fetch_mutex_);
        if (!wait_for_slot(i)) return;
        error = guarded([&] { work_.fetch(i, i % slots_.size()); });
      }
      if (!error) error = guarded([&] { work_.work(i, i % slots_.size()); });
      {
        const std::lock_guard lock(mutex_);
        slots_[i % slots_.size()] = {true, error};
      }
      changed_.notify_all();
    }
  }

  /// Takes the next item once its slot is free; false where there is nothing more to do.
  bool wait_for_slot(std::size_t& i) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stopped_ || next_ < delivered_ + slots_.size(); });
    if (stopped_ || next_ >= work_.count) return false;
    i = next_++;
    return true;
  }

  template <class Step>
  static std::exception_ptr guarded(Step step) {
    try {
      step();
    } catch (...) {
      return std::current_exception();
    }
    return nullptr;
  }

  const OrderedWork& work_;
  std::mutex mutex_;
  std::mutex fetch_mutex_;
  std::condition_variable changed_;
  std::vector<Slot> slots_;
  std::size_t next_ = 0;
  std::size_t delivered_ = 0;
  bool stopped_ = false;
};

}  // namespace

std::size_t ordered_slots(int threads) {
  const int n = thread_count(threads);
  return n <= 1 ? 1 : 2 * static_cast<std::size_t>(n);
}

void run_ordered(const OrderedWork& work) {
  const auto threads =
      static_cast<int>(std::min<std::size_t>(thread_count(work.threads), work.count));
  if (threads <= 1) return run_here(work);
  Pipeline(work, ordered_slots(work.threads)).run(threads);
}

}  // namespace cornice
