// SPDX-License-Identifier: GPL-3.0-or-later
// Points and passes of every point source id.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "stages/info/facts.h"

namespace cornice::info {

/// Collects times by point source id and channel. Memory grows with the seconds flown, up to a
/// limit; passes are not told beyond it.
class LineTable {
 public:
  /// time_s: of a point with a good time; nothing otherwise.
  void add(std::uint16_t id, std::uint8_t channel, std::optional<double> time_s);

  std::vector<LineFacts> lines() const;
  bool complete() const { return complete_; }
  /// Points whose time lies before that of the point before them of the same line.
  std::uint64_t steps_back() const { return steps_back_; }

 private:
  struct Line {
    LineFacts facts;
    double latest_s = 0.0;
    std::int64_t latest_bin = 0;
    std::set<std::int64_t> bins;  ///< whole kBin_s seconds in which it has points
  };
  static std::uint64_t passes_of(const Line& line);

  std::map<std::pair<std::uint16_t, std::uint8_t>, Line> lines_;
  Line* latest_ = nullptr;
  std::size_t bins_ = 0;
  bool complete_ = true;
  std::uint64_t steps_back_ = 0;
};

}  // namespace cornice::info
