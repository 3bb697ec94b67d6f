// SPDX-License-Identifier: GPL-3.0-or-later
// How much detail a target for the time of a frame leaves.
#pragma once

#include <vector>

namespace cornice::viewer {

/// Moves the detail so that drawing a frame takes at most a target. What makes it calm: it goes by
/// the median of the frames of half a second, does nothing between kComfort and the whole of the
/// target, aims at the middle of that band, gives detail back in small steps, and after each change
/// waits until the frames are of the new detail. Where frames take far too long it answers at once.
class FrameBudget {
 public:
  /// 0: no target, the share is 1.
  void set_target_ms(double target_ms);
  double target_ms() const { return target_ms_; }
  /// A frame took draw_ms to choose and to draw, without waiting for the display; seconds since the
  /// one before. Returns share().
  double add(double draw_ms, double seconds);
  /// Of the detail that the error on the screen asks for, kLeast..1: distances at which levels
  /// change are to be this times as large, the error on the screen 1 / share.
  double share() const { return share_; }

  static constexpr double kLeast = 0.02;
  static constexpr double kComfort = 0.75;

 private:
  void move_to(double share);

  double target_ms_ = 0.0;
  double share_ = 1.0;
  double since_change_s_ = 0.0;
  double window_s_ = 0.0;
  std::vector<double> window_ms_;
};

}  // namespace cornice::viewer
