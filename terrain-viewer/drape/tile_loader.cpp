// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/drape/tile_loader.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_set>
#include <utility>

namespace cornice::viewer {

/// Guarded by `mutex` but for `pyramid`, which is the thread's, and `ends`.
struct TileLoader::State {
  std::unique_ptr<RasterPyramid> pyramid;
  mutable std::mutex mutex;
  std::condition_variable work, idle;
  std::atomic<bool> ends{false};
  std::vector<TileKey> wanted;  ///< the most urgent last
  std::optional<TileKey> in_hand;
  std::deque<RasterTile> ready;
  std::unordered_set<TileKey, TileKeyHash> failed;
  std::vector<std::string> failures;
  std::uint64_t tiles_read = 0;
  std::thread thread;

  bool is_known(TileKey key) const {
    return failed.contains(key) || in_hand == key ||
           std::any_of(ready.begin(), ready.end(),
                       [&](const RasterTile& tile) { return tile.key == key; });
  }
  bool may_read() const { return !wanted.empty() && ready.size() < kMostReady; }

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      work.wait(lock, [&] { return ends || may_read(); });
      if (ends) return;
      const TileKey key = wanted.back();
      wanted.pop_back();
      in_hand = key;
      lock.unlock();
      std::optional<RasterTile> tile;
      std::string problem;
      try {
        tile = pyramid->read(key, &ends);
      } catch (const std::exception& error) {
        problem = error.what();
      }
      lock.lock();
      in_hand.reset();
      if (tile) {
        ++tiles_read;
        ready.push_back(std::move(*tile));
      } else {
        failed.insert(key);
        failures.push_back(problem);
      }
      if (!may_read()) idle.notify_all();
    }
  }
};

TileLoader::TileLoader(std::unique_ptr<RasterPyramid> pyramid) : state_(std::make_unique<State>()) {
  state_->pyramid = std::move(pyramid);
  state_->thread = std::thread([this] { state_->run(); });
}

TileLoader::~TileLoader() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->ends = true;
  }
  state_->work.notify_all();
  state_->thread.join();
}

void TileLoader::want(const std::vector<TileKey>& keys) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->wanted.clear();
    for (auto key = keys.rbegin(); key != keys.rend(); ++key)
      if (!state_->is_known(*key)) state_->wanted.push_back(*key);
  }
  state_->work.notify_all();
}

std::vector<RasterTile> TileLoader::take(std::size_t most) {
  std::vector<RasterTile> tiles;
  {
    const std::lock_guard lock(state_->mutex);
    while (tiles.size() < most && !state_->ready.empty()) {
      tiles.push_back(std::move(state_->ready.front()));
      state_->ready.pop_front();
    }
  }
  state_->work.notify_all();
  return tiles;
}

void TileLoader::wait() {
  std::unique_lock lock(state_->mutex);
  state_->idle.wait(lock, [&] { return !state_->may_read() && !state_->in_hand; });
}

bool TileLoader::has_failed(TileKey key) const {
  const std::lock_guard lock(state_->mutex);
  return state_->failed.contains(key);
}

std::vector<std::string> TileLoader::take_failures() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->failures, {});
}

std::uint64_t TileLoader::tiles_read() const {
  const std::lock_guard lock(state_->mutex);
  return state_->tiles_read;
}

}  // namespace cornice::viewer
