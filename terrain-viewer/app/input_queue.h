// SPDX-License-Identifier: GPL-3.0-or-later
// What keys and the mouse did, shared out among frames so that each of it counts, however slow they
// are. A frame knows one cursor, and of each key and button whether it is down: two clicks in it
// would be one. Knows no window.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <vector>

namespace cornice::viewer {

struct InputEvent {
  enum class Kind { kKey, kCharacter, kButton, kMove, kWheel };
  Kind kind = Kind::kMove;
  int code = 0;              ///< key, character or button
  int scancode = 0;          ///< of a key
  int held = 0;              ///< bits of the modifiers held
  bool is_down = false;      ///< went down, of a key or button; else up
  bool is_modifier = false;  ///< a key that does nothing alone
  bool is_letter = false;    ///< a key that counts as a character while text is entered
  double x = 0.0, y = 0.0;   ///< cursor; of kWheel how far it turned
  double time_s = 0.0;
  bool is_second = false;  ///< set by add: the second press of a double click
};

class InputQueue {
 public:
  static constexpr double kDoubleClickS = 0.3, kDoubleClickPixels = 6.0;

  /// frame_s: length of the frame before; times are known no better.
  void add(InputEvent event, double frame_s = 0.0) {
    if (event.kind == InputEvent::Kind::kButton && event.is_down) {
      event.is_second =
          last_press_ && last_press_->code == event.code &&
          event.time_s - last_press_->time_s <= kDoubleClickS + frame_s &&
          std::hypot(event.x - last_press_->x, event.y - last_press_->y) <= kDoubleClickPixels;
      // A third is the first of another two.
      last_press_ = event.is_second ? std::nullopt : std::optional(event);
    }
    events_.push_back(event);
  }

  /// What the next frame is to see, in its order; the rest waits. types: text is being entered.
  std::vector<InputEvent> take(bool types) {
    std::vector<InputEvent> frame;
    while (!events_.empty() && fits(frame, events_.front(), types)) {
      frame.push_back(events_.front());
      events_.pop_front();
    }
    return frame;
  }
  bool empty() const { return events_.empty(); }

 private:
  static bool fits(const std::vector<InputEvent>& frame, const InputEvent& next, bool types) {
    using Kind = InputEvent::Kind;
    const auto none = [&](const auto& clashes) {
      return std::none_of(frame.begin(), frame.end(), clashes);
    };
    const bool is_typed = types && next.is_letter;
    switch (next.kind) {
      case Kind::kMove:
        // What was clicked was where the cursor was then.
        return none([](const InputEvent& e) { return e.kind == Kind::kButton; }) &&
               none([](const InputEvent& e) { return e.kind == Kind::kWheel; });
      case Kind::kButton:
        // A drag ends after its last step.
        return none([&](const InputEvent& e) {
          return (e.kind == Kind::kButton && e.code == next.code) ||
                 (e.kind == Kind::kMove && !next.is_down);
        });
      case Kind::kCharacter:
        return none([](const InputEvent& e) { return is_command(e, true); });
      case Kind::kKey:
        if (is_typed) return true;
        return none([&](const InputEvent& e) {
          return e.kind == Kind::kKey &&
                 (e.code == next.code || (is_command(e, types) && is_command(next, types)));
        });
      default:
        return true;
    }
  }
  /// One for each frame: what it does may change what the next one is for.
  static bool is_command(const InputEvent& e, bool types) {
    return e.kind == InputEvent::Kind::kKey && e.is_down && !e.is_modifier &&
           !(types && e.is_letter);
  }

  std::deque<InputEvent> events_;
  std::optional<InputEvent> last_press_;
};

}  // namespace cornice::viewer
