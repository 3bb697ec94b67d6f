// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/index/box_finder.h"

#include <algorithm>
#include <utility>

namespace cornice::index {

BoxFinder::BoxFinder(std::vector<Box2d> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  Box2d all;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    all.add(boxes_[i].min_x, boxes_[i].min_y);
    order_[i] = i;
  }
  along_x_ = all.width() >= all.height();
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::size_t i, std::size_t j) { return low(boxes_[i]) < low(boxes_[j]); });
  for (const std::size_t i : order_) {
    lows_.push_back(low(boxes_[i]));
    longest_ = std::max(longest_, high(boxes_[i]) - low(boxes_[i]));
  }
}

std::vector<std::size_t> BoxFinder::touching(const Box2d& box) const {
  std::vector<std::size_t> found;
  const auto first = std::lower_bound(lows_.begin(), lows_.end(), low(box) - longest_);
  for (auto at = first; at != lows_.end() && *at <= high(box); ++at) {
    const std::size_t i = order_[static_cast<std::size_t>(at - lows_.begin())];
    if (boxes_[i].intersects(box)) found.push_back(i);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace cornice::index
