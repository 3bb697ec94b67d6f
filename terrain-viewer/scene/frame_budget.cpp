// SPDX-License-Identifier: GPL-3.0-or-later
// A reactive scheduler: Luebke and others, "Level of detail for 3D graphics", 2003, chapter 4.
#include "terrain-viewer/scene/frame_budget.h"

#include <algorithm>
#include <cmath>

namespace cornice::viewer {
namespace {

/// After a change levels go on moving for about so long (Layer moves them smoothly).
constexpr double kSettleSeconds = 0.7;
constexpr double kWindowSeconds = 0.5;
constexpr std::size_t kFewestFrames = 5;
/// Frames longer than this times the target need no whole window.
constexpr double kFarTooLong = 1.6;
constexpr double kLargestRise = 1.12;
constexpr double kLargestFall = 0.35;

}  // namespace

void FrameBudget::set_target_ms(double target_ms) {
  if (target_ms == target_ms_) return;
  target_ms_ = target_ms;
  window_ms_.clear();
  window_s_ = 0.0;
  judged_ = 0;
  if (!(target_ms > 0.0)) share_ = 1.0;
}

double FrameBudget::add(double draw_ms, double seconds) {
  if (!(target_ms_ > 0.0)) return share_;
  since_change_s_ += seconds;
  if (since_change_s_ < kSettleSeconds) return share_;
  window_ms_.push_back(draw_ms);
  window_s_ += seconds;
  if (window_ms_.size() < kFewestFrames) return share_;
  const auto middle = window_ms_.begin() + static_cast<std::ptrdiff_t>(window_ms_.size() / 2);
  std::nth_element(window_ms_.begin(), middle, window_ms_.end());
  const double median = std::max(*middle, 1e-3);
  if (window_s_ < kWindowSeconds && median < kFarTooLong * target_ms_) return share_;
  // Triangles, and with them time, grow at most with the square of the distances.
  const double aim = 0.5 * (1.0 + kComfort) * target_ms_;
  const double factor = std::sqrt(aim / median);
  ++judged_;
  if (median > target_ms_)
    move_to(share_ * std::max(factor, kLargestFall));
  else if (median < kComfort * target_ms_)
    move_to(share_ * std::min(factor, kLargestRise));
  window_ms_.clear();
  window_s_ = 0.0;
  return share_;
}

void FrameBudget::move_to(double share) {
  share = std::clamp(share, kLeast, 1.0);
  if (share == share_) return;
  since_change_s_ = 0.0;
  judged_ = 0;
  share_ = share;
}

}  // namespace cornice::viewer
