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
  /// What is drawn has changed: frames are to be timed again.
  void look_anew() { judged_ = 0; }
  /// True once frames of what is drawn now have asked for no change, and without a target.
  bool is_settled() const { return !(target_ms_ > 0.0) || judged_ >= kEnoughJudged; }
  /// Of the detail that the error on the screen asks for, kLeast..1: distances at which levels
  /// change are to be this times as large, the error on the screen 1 / share.
  double share() const { return share_; }

  static constexpr double kLeast = 0.02;
  static constexpr double kComfort = 0.75;

 private:
  /// The second window in a row is wholly of what is drawn now.
  static constexpr int kEnoughJudged = 2;

  void move_to(double share);

  double target_ms_ = 0.0;
  double share_ = 1.0;
  double since_change_s_ = 0.0;
  double window_s_ = 0.0;
  std::vector<double> window_ms_;
  int judged_ = 0;  ///< windows in a row that asked for no change
};

}  // namespace cornice::viewer
