// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/info/line_table.h"

#include <algorithm>
#include <cmath>

namespace cornice::info {
namespace {

/// A tile is crossed in about 15 s; a bin of 1 s keeps a gap's length to within 5 %.
constexpr double kBin_s = 1.0;
constexpr std::size_t kMostBins = 1'000'000;
constexpr double kLatestTime_s = 1e15;  // of bins that fit 64 bits with room

}  // namespace

void LineTable::add(std::uint16_t id, std::uint8_t channel, std::optional<double> time_s) {
  if (latest_ == nullptr || latest_->facts.point_source_id != id ||
      latest_->facts.channel != channel) {
    latest_ = &lines_[{id, channel}];
    latest_->facts.point_source_id = id;
    latest_->facts.channel = channel;
  }
  Line& line = *latest_;
  ++line.facts.points;
  if (!time_s || *time_s > kLatestTime_s) return;
  LineFacts& facts = line.facts;
  const bool is_first = !facts.first_s;
  if (!is_first && *time_s < line.latest_s) ++steps_back_;
  line.latest_s = *time_s;
  facts.first_s = is_first ? *time_s : std::min(*facts.first_s, *time_s);
  facts.last_s = is_first ? *time_s : std::max(*facts.last_s, *time_s);
  const auto bin = static_cast<std::int64_t>(std::floor(*time_s / kBin_s));
  if (!is_first && bin == line.latest_bin) return;
  line.latest_bin = bin;
  if (bins_ >= kMostBins) {
    complete_ = false;
  } else if (line.bins.insert(bin).second) {
    ++bins_;
  }
}

std::uint64_t LineTable::passes_of(const Line& line) {
  std::uint64_t passes = 0;
  std::int64_t previous = 0;
  for (const std::int64_t bin : line.bins) {
    const double silence_s = static_cast<double>(bin - previous - 1) * kBin_s;
    if (passes == 0 || silence_s > kPassGap_s) ++passes;
    previous = bin;
  }
  return passes;
}

std::vector<LineFacts> LineTable::lines() const {
  std::vector<LineFacts> result;
  for (const auto& [key, line] : lines_) {
    result.push_back(line.facts);
    result.back().passes = passes_of(line);
  }
  return result;
}

}  // namespace cornice::info
