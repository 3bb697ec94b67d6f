// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/info/copy_counter.h"

#include <algorithm>
#include <cmath>

namespace cornice::info {

void CopyCounter::collect() {
  std::sort(fresh_.begin(), fresh_.end());
  std::vector<Entry> merged;
  merged.reserve(sorted_.size() + fresh_.size());
  const auto append = [&](Entry entry) {
    if (!merged.empty() && merged.back().hash == entry.hash) {
      merged.back().seen += entry.seen;
    } else {
      merged.push_back(entry);
    }
  };
  std::size_t old = 0;
  for (const std::uint64_t hash : fresh_) {
    while (old < sorted_.size() && sorted_[old].hash <= hash) append(sorted_[old++]);
    append({hash, 1});
  }
  while (old < sorted_.size()) append(sorted_[old++]);
  fresh_.clear();
  sorted_ = std::move(merged);
  while (sorted_.size() > kMostKept) {
    highest_ /= 2;
    share_ /= 2.0;
    const auto end = std::partition_point(sorted_.begin(), sorted_.end(),
                                          [this](const Entry& e) { return e.hash <= highest_; });
    sorted_.erase(end, sorted_.end());
  }
}

CopyCounter::Count CopyCounter::count() {
  collect();
  std::uint64_t copies = 0;
  for (const Entry& entry : sorted_) copies += entry.seen - 1;
  if (share_ == 1.0) return {copies, false};
  return {static_cast<std::uint64_t>(std::llround(static_cast<double>(copies) / share_)), true};
}

}  // namespace cornice::info
