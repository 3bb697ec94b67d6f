// SPDX-License-Identifier: GPL-3.0-or-later
// Which of many boxes touch a given one, without asking all of them.
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/vec.h"

namespace cornice::index {

/// Boxes in the order of their west (or south) edges. A query looks at those whose edge lies near
/// enough, so one box far longer than the others makes it slow, not wrong.
class BoxFinder {
 public:
  explicit BoxFinder(std::vector<Box2d> boxes);

  /// Indices of the boxes that share a point with `box`, borders included, ascending.
  std::vector<std::size_t> touching(const Box2d& box) const;

 private:
  double low(const Box2d& box) const { return along_x_ ? box.min_x : box.min_y; }
  double high(const Box2d& box) const { return along_x_ ? box.max_x : box.max_y; }

  std::vector<Box2d> boxes_;
  std::vector<std::size_t> order_;  ///< by `low`
  std::vector<double> lows_;        ///< of `order_`
  bool along_x_ = true;             ///< the way in which the boxes are spread farther
  double longest_ = 0.0;            ///< box, that way
};

}  // namespace cornice::index
