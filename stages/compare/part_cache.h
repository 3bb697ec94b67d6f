// SPDX-License-Identifier: GPL-3.0-or-later
// Files that were read, kept as long as memory lasts.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <utility>

namespace cornice::compare {

/// Keeps the values used last while they take no more than `limit_bytes` together, one at least.
template <class T>
class PartCache {
 public:
  explicit PartCache(std::uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}

  std::shared_ptr<const T> get(std::size_t key,
                               const std::function<std::shared_ptr<const T>()>& make,
                               const std::function<std::uint64_t(const T&)>& bytes_of) {
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      if (entry->key != key) continue;
      entries_.splice(entries_.begin(), entries_, entry);
      return entries_.front().value;
    }
    // Room first: the new one may be as large as the last.
    while (entries_.size() > 1 &&
           2 * entries_.front().bytes + held_ > limit_bytes_ + entries_.front().bytes) {
      drop_last();
    }
    std::shared_ptr<const T> value = make();
    const std::uint64_t bytes = bytes_of(*value);
    entries_.push_front({key, bytes, std::move(value)});
    held_ += bytes;
    while (entries_.size() > 1 && held_ > limit_bytes_) drop_last();
    return entries_.front().value;
  }

 private:
  struct Entry {
    std::size_t key;
    std::uint64_t bytes;
    std::shared_ptr<const T> value;
  };
  void drop_last() {
    held_ -= entries_.back().bytes;
    entries_.pop_back();
  }

  std::uint64_t limit_bytes_;
  std::uint64_t held_ = 0;
  std::list<Entry> entries_;
};

}  // namespace cornice::compare
