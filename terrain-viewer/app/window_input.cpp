// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/window_input.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "terrain-viewer/app/key_actions.h"

namespace cornice::viewer {

// Events go into the queue in place of ImGui, which gets them from there.
WindowInput::WindowInput(GLFWwindow* window) : window_(window) {
  glfwSetWindowUserPointer(window, this);
  listen_to_keys();
  listen_to_mouse();
  listen_to_window();
}

void WindowInput::listen_to_window() {
  // An exception may not go through GLFW: files are opened in the frame.
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
    of(w).dropped_.insert(of(w).dropped_.end(), paths, paths + count);
    of(w).has_news_ = true;
  });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { of(w).has_news_ = true; });
  glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* w, int, int) { of(w).has_news_ = true; });
  glfwSetWindowContentScaleCallback(window_,
                                    [](GLFWwindow* w, float, float) { of(w).has_news_ = true; });
}

void WindowInput::listen_to_keys() {
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int scancode, int action, int held) {
    if (action == GLFW_REPEAT) return;
    const bool is_modifier = key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER;
    const bool is_letter = key < GLFW_KEY_ESCAPE && (held & GLFW_MOD_CONTROL) == 0;
    of(w).happened({.kind = InputEvent::Kind::kKey,
                    .code = key,
                    .scancode = scancode,
                    .held = held,
                    .is_down = action == GLFW_PRESS,
                    .is_modifier = is_modifier,
                    .is_letter = is_letter});
  });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned int character) {
    of(w).happened({.kind = InputEvent::Kind::kCharacter, .code = static_cast<int>(character)});
  });
}

void WindowInput::listen_to_mouse() {
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int held) {
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    // GLFW would say where the cursor is by now; a slow frame hears of the press much later.
    of(w).happened({.kind = InputEvent::Kind::kButton,
                    .code = button,
                    .held = held,
                    .is_down = action == GLFW_PRESS,
                    .x = of(w).latest_[0],
                    .y = of(w).latest_[1]});
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double x, double y) {
    of(w).happened({.kind = InputEvent::Kind::kWheel, .x = x, .y = y});
  });
  // ImGui has none of its own before 1.87.
  move_of_imgui_ = glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
    of(w).latest_ = {x, y};
    of(w).happened({.kind = InputEvent::Kind::kMove, .x = x, .y = y});
  });
  glfwGetCursorPos(window_, &pointer_[0], &pointer_[1]);
  latest_ = pointer_;
}

void WindowInput::happened(InputEvent event) {
  event.time_s = glfwGetTime();
  events_.add(event, frame_s_);
  has_news_ = true;
}

bool WindowInput::has_more() const {
  return !events_.empty() || waiting_frames_ > 0 || !down_.empty() ||
         std::find(buttons_.begin(), buttons_.end(), true) != buttons_.end();
}

void WindowInput::begin_frame(double seconds) {
  frame_s_ = seconds;
  presses_.clear();
  is_double_click_ = false;
  if (waiting_frames_ > 0)
    --waiting_frames_;
  else
    take_events();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  use_interface_scale(window_);
  tell_pointer();
}

void WindowInput::take_key(const InputEvent& event) {
  const int action = event.is_down ? GLFW_PRESS : GLFW_RELEASE;
  ImGui_ImplGlfw_KeyCallback(window_, event.code, event.scancode, action, event.held);
  if (!event.is_down) {
    down_.erase(event.code);
    return;
  }
  down_.insert(event.code);
  const int named = key_by_name(event.code, glfwGetKeyName(event.code, event.scancode));
  presses_.push_back({named, event.held});
}

void WindowInput::take_events() {
  for (const InputEvent& event : events_.take(ImGui::GetIO().WantTextInput)) {
    switch (event.kind) {
      case InputEvent::Kind::kKey:
        take_key(event);
        break;
      case InputEvent::Kind::kCharacter:
        ImGui_ImplGlfw_CharCallback(window_, static_cast<unsigned int>(event.code));
        break;
      case InputEvent::Kind::kButton:
        ImGui_ImplGlfw_MouseButtonCallback(window_, event.code,
                                           event.is_down ? GLFW_PRESS : GLFW_RELEASE, event.held);
        buttons_[static_cast<std::size_t>(event.code)] = event.is_down;
        is_double_click_ |= event.is_second && event.code == GLFW_MOUSE_BUTTON_LEFT;
        pointer_ = {event.x, event.y};
        break;
      case InputEvent::Kind::kWheel:
        ImGui_ImplGlfw_ScrollCallback(window_, event.x, event.y);
        break;
      case InputEvent::Kind::kMove: {
        const double scale = interface_units(window_);
        if (move_of_imgui_ != nullptr) move_of_imgui_(window_, event.x * scale, event.y * scale);
        pointer_ = {event.x, event.y};
      }
    }
  }
}

// ImGui before 1.87 asks GLFW where the mouse is now, which may be ahead of the queue.
void WindowInput::tell_pointer() {
  ImGuiIO& io = ImGui::GetIO();
  const double scale = interface_units(window_);
  if (io.MousePos.x >= 0.0f) io.MousePos = {float(pointer_[0] * scale), float(pointer_[1] * scale)};
  std::copy(buttons_.begin(), buttons_.end(), std::begin(io.MouseDown));
}

std::array<double, 2> WindowInput::pointer() const {
  const double scale = pixels_per_unit(window_);
  return {pointer_[0] * scale, pointer_[1] * scale};
}

bool WindowInput::has_pads() const {
  for (int joystick = GLFW_JOYSTICK_1; joystick <= GLFW_JOYSTICK_LAST; ++joystick)
    if (glfwJoystickIsGamepad(joystick) == GLFW_TRUE) return true;
  return false;
}

PadMove WindowInput::pads() const {
  std::vector<PadState> pads;
  if (glfwGetWindowAttrib(window_, GLFW_FOCUSED) == GLFW_FALSE) return {};
  for (int joystick = GLFW_JOYSTICK_1; joystick <= GLFW_JOYSTICK_LAST; ++joystick) {
    GLFWgamepadstate state{};
    if (glfwGetGamepadState(joystick, &state) != GLFW_TRUE) continue;
    PadState& pad = pads.emplace_back();
    std::copy(std::begin(state.axes), std::end(state.axes), pad.axes.begin());
    std::copy(std::begin(state.buttons), std::end(state.buttons), pad.buttons.begin());
  }
  return pad_move(pads);
}

}  // namespace cornice::viewer
