// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/cell_page.h"

#include <algorithm>
#include <cassert>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "core/base/error.h"

namespace cornice::viewer {

PageBuffers make_page_buffers(const PageSize& size) {
  const auto longest = [](std::uint64_t bytes) {
    return static_cast<std::size_t>(std::max<std::uint64_t>(bytes, 4));
  };
  return {make_buffer(longest(PageSize{size.vertices, 0}.bytes())),
          make_buffer(longest(PageSize{0, size.indices}.bytes()))};
}

struct PageMaker::State {
  std::unique_ptr<SecondContext> context;
  std::mutex mutex;
  std::condition_variable work, done;
  bool ends = false;
  std::optional<PageSize> wanted;
  std::optional<PageBuffers> made;
  std::thread thread;

  static PageBuffers make(const PageSize& size) {
    try {
      PageBuffers buffers = make_page_buffers(size);
      // Only what is finished here is sure to be seen by the other context.
      glFinish();
      return buffers;
    } catch (const RunError&) {
      return {};
    }
  }

  void run() {
    const bool is_current = context->make_current();
    std::unique_lock lock(mutex);
    while (true) {
      work.wait(lock, [&] { return ends || wanted; });
      if (ends) break;
      const PageSize size = *std::exchange(wanted, std::nullopt);
      lock.unlock();
      PageBuffers buffers = is_current ? make(size) : PageBuffers{};
      lock.lock();
      made = std::move(buffers);
      done.notify_all();
    }
    lock.unlock();
    // Here, where a context is current: the other thread's may have gone.
    made.reset();
    if (is_current) context->release();
  }
};

PageMaker::PageMaker(std::unique_ptr<SecondContext> context) : state_(std::make_unique<State>()) {
  state_->context = std::move(context);
  state_->thread = std::thread([this] { state_->run(); });
}

PageMaker::~PageMaker() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->ends = true;
  }
  state_->work.notify_all();
  state_->thread.join();
}

void PageMaker::want(const PageSize& size) {
  assert(!size_);
  size_ = size;
  {
    const std::lock_guard lock(state_->mutex);
    state_->wanted = size;
  }
  state_->work.notify_all();
}

std::optional<PageMaker::Made> PageMaker::take(bool waits) {
  if (!size_) return std::nullopt;
  std::unique_lock lock(state_->mutex);
  if (waits) state_->done.wait(lock, [&] { return state_->made.has_value(); });
  if (!state_->made) return std::nullopt;
  Made made{*std::exchange(size_, std::nullopt), std::move(*state_->made)};
  state_->made.reset();
  return made;
}

}  // namespace cornice::viewer
