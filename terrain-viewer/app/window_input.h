// SPDX-License-Identifier: GPL-3.0-or-later
// Keys, mouse, gamepads and dropped files of a window, frame by frame.
#pragma once

#include <array>
#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "terrain-viewer/app/gamepad.h"
#include "terrain-viewer/app/input_queue.h"
#include "terrain-viewer/app/window_system.h"

namespace cornice::viewer {

/// A key that went down, by the letter it carries, and the GLFW_MOD_ bits of those held then.
struct KeyPress {
  int key = 0, held = 0;
};

/// For the main thread; takes the window's callbacks and its user pointer until it ends.
class WindowInput {
 public:
  explicit WindowInput(GLFWwindow* window);
  WindowInput(const WindowInput&) = delete;
  WindowInput& operator=(const WindowInput&) = delete;

  /// Begins a frame: tells ImGui, and this object, what it is to know; around ImGui's back ends'
  /// and before ImGui's own NewFrame. seconds: length of the frame before.
  void begin_frame(double seconds);
  /// Keeps all that happens waiting for so many frames.
  void wait(int frames) { waiting_frames_ = frames; }

  const std::vector<KeyPress>& presses() const { return presses_; }
  /// Keys are told by their place on the keyboard.
  bool is_down(int key) const { return down_.count(key) != 0; }
  bool is_double_click() const { return is_double_click_; }
  /// The cursor as this frame knows it, pixels of the framebuffer.
  std::array<double, 2> pointer() const;
  /// What all gamepads that are plugged in ask for; nothing while another window has the focus.
  PadMove pads() const;
  /// True where such a pad is plugged in: pads do not wake who waits for events.
  bool has_pads() const;
  /// True where the window was asked to do or to show something since the last call.
  bool take_news() { return std::exchange(has_news_, false); }
  /// True where the next frame is to see what this one did not: events that wait, keys and buttons
  /// that are held.
  bool has_more() const;
  /// Files dropped since the last call.
  std::vector<std::filesystem::path> take_dropped() { return std::exchange(dropped_, {}); }

 private:
  static WindowInput& of(GLFWwindow* window) {
    return *static_cast<WindowInput*>(glfwGetWindowUserPointer(window));
  }
  void listen_to_keys();
  void listen_to_mouse();
  void listen_to_window();
  void happened(InputEvent event);
  void take_events();
  void take_key(const InputEvent& event);
  void tell_pointer();

  GLFWwindow* window_;
  InputQueue events_;
  std::vector<KeyPress> presses_;    ///< of this frame
  std::set<int> down_;               ///< keys
  std::array<double, 2> pointer_{};  ///< as this frame knows it, screen units
  std::array<double, 2> latest_{};   ///< as the latest event said
  std::array<bool, 3> buttons_{};    ///< left, right, middle
  bool is_double_click_ = false;
  bool has_news_ = false;
  int waiting_frames_ = 0;  ///< in which no event is taken
  double frame_s_ = 0.0;
  GLFWcursorposfun move_of_imgui_ = nullptr;
  std::vector<std::filesystem::path> dropped_;
};

}  // namespace cornice::viewer
