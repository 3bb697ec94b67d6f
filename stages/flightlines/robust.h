// SPDX-License-Identifier: GPL-3.0-or-later
// Small robust statistics that the estimates of this stage share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace cornice::flightlines {

inline constexpr double kRadians = std::numbers::pi / 180.0;

/// Upper median; reorders `values`; 0 of nothing.
inline double median_in_place(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

inline double median_of(std::vector<double> values) { return median_in_place(values); }

/// Weight of Huber while an estimate is still far off, then of Geman and McClure: far outliers
/// count for nothing, but only once it is known what is far. `ratio`: residual over its scale.
inline double robust_weight(double ratio, bool is_early) {
  if (is_early) return 1.0 / std::max(1.0, ratio);
  const double w = 1.0 / (1.0 + ratio * ratio / 9.0);
  return w * w;
}

/// The cost that goes with robust_weight.
inline double robust_cost(double ratio) { return ratio * ratio / (1.0 + ratio * ratio / 9.0); }

}  // namespace cornice::flightlines
