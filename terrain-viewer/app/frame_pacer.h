// SPDX-License-Identifier: GPL-3.0-or-later
// When a window draws: frame after frame while anything moves, otherwise not at all. Knows no
// window.
#pragma once

#include <algorithm>
#include <optional>

namespace cornice::viewer {

/// Times are seconds of any one clock.
class FramePacer {
 public:
  /// What an event did to the scene shows in the second frame after it, panels that then fit
  /// themselves to what is in them in the third; one more for what these do in turn.
  static constexpr int kFramesAfterNews = 4;
  /// Between frames that only bring numbers up to date.
  static constexpr double kRefreshS = 0.25;
  /// What a frame after a pause counts as at most: nothing moved meanwhile.
  static constexpr double kFirstFrameS = 1.0 / 60.0;
  static constexpr double kShortestFrameS = 1e-4, kLongestFrameS = 0.25;

  struct Frame {
    double seconds = 0.0;         ///< by which what moves is to move
    double since_last_s = 0.0;    ///< since the frame before was drawn, pauses included
    bool is_after_pause = false;  ///< it did not follow the one before at once
  };

  explicit FramePacer(double now_s) : last_s_(now_s) {}

  /// Something happened that may show.
  void wake() { frames_left_ = kFramesAfterNews; }
  bool is_awake() const { return frames_left_ > 0; }
  /// The window cannot be seen: draws at once when it can.
  void hide() {
    wake();
    is_paused_ = true;
  }
  /// The frame to be drawn now, if there is one.
  std::optional<Frame> next(double now_s) {
    if (!is_awake() && !(refreshes_ && now_s - last_s_ >= kRefreshS)) return std::nullopt;
    Frame frame;
    frame.since_last_s = std::max(now_s - last_s_, kShortestFrameS);
    frame.seconds = std::min(frame.since_last_s, is_paused_ ? kFirstFrameS : kLongestFrameS);
    frame.is_after_pause = is_paused_;
    last_s_ = now_s;
    return frame;
  }
  /// The frame is drawn. moves: another one would differ. refreshes: it shows numbers that change
  /// by themselves.
  void drawn(bool moves, bool refreshes) {
    frames_left_ = std::max(frames_left_ - 1, moves ? 1 : 0);
    refreshes_ = refreshes;
    is_paused_ = !is_awake();
  }
  /// How long to wait for events, at most longest_s.
  double wait_s(double now_s, double longest_s) const {
    return refreshes_ ? std::clamp(last_s_ + kRefreshS - now_s, 1e-3, longest_s) : longest_s;
  }

 private:
  int frames_left_ = kFramesAfterNews;
  bool refreshes_ = false, is_paused_ = false;
  double last_s_;
};

}  // namespace cornice::viewer
