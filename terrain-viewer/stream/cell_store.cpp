// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/stream/cell_store.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace cornice::viewer {

/// Guarded by `mutex` but for `file`, which may be read from several threads.
struct CellStore::State {
  struct Held {
    std::shared_ptr<const PackedCell> cell;
    std::list<std::uint32_t>::iterator place;  ///< in `used`
  };

  std::shared_ptr<const hlod::File> file;
  CellStoreOptions options;
  mutable std::mutex mutex;
  std::condition_variable work, idle;
  bool ends = false;
  std::vector<std::uint32_t> wanted;  ///< the most urgent last
  std::unordered_set<std::uint32_t> in_hand, failed;
  std::unordered_map<std::uint32_t, Held> held;
  std::list<std::uint32_t> used;  ///< the latest first
  std::vector<std::string> failures;
  CellStoreCounts counts;
  std::vector<std::thread> threads;

  using Cells = std::vector<std::shared_ptr<const PackedCell>>;

  /// Appends what goes for it to `dropped`, to be freed without the lock.
  void keep(std::shared_ptr<const PackedCell> cell, Cells& dropped) {
    counts.memory_bytes += cell->bytes();
    const std::uint32_t row = cell->node;
    used.push_front(row);
    held[row] = {std::move(cell), used.begin()};
    while (counts.memory_bytes > options.memory_bytes && used.size() > 1) {
      const auto oldest = held.find(used.back());
      counts.memory_bytes -= oldest->second.cell->bytes();
      dropped.push_back(std::move(oldest->second.cell));
      held.erase(oldest);
      used.pop_back();
    }
  }

  /// Reads one cell; `lock` is open meanwhile.
  void read(std::uint32_t row, std::unique_lock<std::mutex>& lock) {
    in_hand.insert(row);
    lock.unlock();
    std::shared_ptr<const PackedCell> cell;
    std::string problem;
    const hlod::Node& node = file->nodes()[row];
    try {
      cell = std::make_shared<PackedCell>(pack_cell(file->read(node), node, row));
    } catch (const std::exception& error) {
      problem = error.what();
    }
    lock.lock();
    in_hand.erase(row);
    if (cell) {
      ++counts.cells_read;
      counts.bytes_read += node.bytes;
      Cells dropped;
      keep(std::move(cell), dropped);
      lock.unlock();
      dropped.clear();
      lock.lock();
    } else {
      ++counts.cells_failed;
      failed.insert(row);
      failures.push_back(problem);
    }
  }

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      work.wait(lock, [&] { return ends || !wanted.empty(); });
      if (ends) return;
      const std::uint32_t row = wanted.back();
      wanted.pop_back();
      if (!held.contains(row) && !in_hand.contains(row) && !failed.contains(row)) read(row, lock);
      if (wanted.empty() && in_hand.empty()) idle.notify_all();
    }
  }
};

CellStore::CellStore(std::shared_ptr<const hlod::File> file, const CellStoreOptions& options)
    : state_(std::make_unique<State>()) {
  state_->file = std::move(file);
  state_->options = options;
  for (int i = 0; i < std::max(1, options.threads); ++i)
    state_->threads.emplace_back([this] { state_->run(); });
}

CellStore::~CellStore() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->ends = true;
  }
  state_->work.notify_all();
  for (std::thread& thread : state_->threads) thread.join();
}

void CellStore::want(const std::vector<std::uint32_t>& rows) {
  bool has_work = false;
  {
    const std::lock_guard lock(state_->mutex);
    state_->wanted.clear();
    for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
      if (const auto found = state_->held.find(*row); found != state_->held.end())
        state_->used.splice(state_->used.begin(), state_->used, found->second.place);
      else if (!state_->failed.contains(*row))
        state_->wanted.push_back(*row);
    }
    has_work = !state_->wanted.empty();
  }
  if (has_work) state_->work.notify_all();
}

std::shared_ptr<const PackedCell> CellStore::find(std::uint32_t row) {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->held.find(row);
  if (found == state_->held.end()) return nullptr;
  state_->used.splice(state_->used.begin(), state_->used, found->second.place);
  return found->second.cell;
}

std::vector<std::string> CellStore::take_failures() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->failures, {});
}

void CellStore::wait() {
  std::unique_lock lock(state_->mutex);
  state_->idle.wait(lock, [&] { return state_->wanted.empty() && state_->in_hand.empty(); });
}

CellStoreCounts CellStore::counts() const {
  const std::lock_guard lock(state_->mutex);
  CellStoreCounts counts = state_->counts;
  counts.cells_waiting = state_->wanted.size() + state_->in_hand.size();
  return counts;
}

}  // namespace cornice::viewer
