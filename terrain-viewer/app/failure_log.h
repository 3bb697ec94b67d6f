// SPDX-License-Identifier: GPL-3.0-or-later
// Messages about parts that could not be read: a few in full, the rest counted. A disk that goes
// away can fail every cell of a survey at once.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace cornice::viewer {

class FailureLog {
 public:
  static constexpr std::size_t kMostInFull = 20;

  /// Of one frame. Returns those that are to be reported in full.
  std::vector<std::string> add(const std::vector<std::string>& failures) {
    const std::size_t room = kMostInFull - std::min(kMostInFull, std::size_t(count_));
    const std::size_t full = std::min(room, failures.size());
    count_ += failures.size();
    if (!failures.empty())
      line_ = failures.back() + "; what is coarser is drawn instead" +
              (count_ > 1 ? " (" + std::to_string(count_) + " such)" : "");
    return {failures.begin(), failures.begin() + static_cast<std::ptrdiff_t>(full)};
  }
  /// One line: the latest, and how many there were in all; empty where there was none.
  const std::string& line() const { return line_; }
  /// How many were not reported in full.
  std::uint64_t untold() const { return count_ > kMostInFull ? count_ - kMostInFull : 0; }

 private:
  std::uint64_t count_ = 0;
  std::string line_;
};

}  // namespace cornice::viewer
