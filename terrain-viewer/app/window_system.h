// SPDX-License-Identifier: GPL-3.0-or-later
// The window with its OpenGL 4.5 and Dear ImGui. For the files that have to do with a window.
#pragma once

#include <epoxy/gl.h>
// After epoxy, which brings OpenGL's declarations.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "terrain-viewer/app/options.h"
#include "terrain-viewer/app/screens.h"
#include "terrain-viewer/render/cell_page.h"
#include "terrain-viewer/render/offscreen_context.h"

namespace cornice::viewer {

/// Pixels of the framebuffer for one of the units in which GLFW tells where the cursor is.
inline double pixels_per_unit(GLFWwindow* window) {
  int units = 0, pixels = 0, height = 0;
  glfwGetWindowSize(window, &units, &height);
  glfwGetFramebufferSize(window, &pixels, &height);
  return units > 0 && pixels > 0 ? double(pixels) / units : 1.0;
}

/// Pixels for one of the units in which panels are laid out: 2 on a display of twice the density,
/// whether the system says so by the size of the framebuffer (Wayland, macOS) or not (X11).
inline double interface_scale(GLFWwindow* window) {
  float x = 1.0f, y = 1.0f;
  glfwGetWindowContentScale(window, &x, &y);
  return std::clamp(std::max(double(x), pixels_per_unit(window)), 1.0, 4.0);
}

/// Units of panels for one of GLFW's.
inline double interface_units(GLFWwindow* window) {
  return pixels_per_unit(window) / interface_scale(window);
}

/// After ImGui's back ends' NewFrame, which know GLFW's units only.
inline void use_interface_scale(GLFWwindow* window) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  const auto scale = static_cast<float>(interface_scale(window));
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {float(width) / scale, float(height) / scale};
  io.DisplayFramebufferScale = {scale, scale};
}

/// That of a hidden window. GLFW wants windows made and ended on the main thread.
class SecondWindowContext : public SecondContext {
 public:
  explicit SecondWindowContext(GLFWwindow* window) : window_(window) {}
  ~SecondWindowContext() override { glfwDestroyWindow(window_); }
  SecondWindowContext(const SecondWindowContext&) = delete;
  SecondWindowContext& operator=(const SecondWindowContext&) = delete;
  bool make_current() override {
    glfwMakeContextCurrent(window_);
    return glfwGetCurrentContext() == window_;
  }
  void release() override { glfwMakeContextCurrent(nullptr); }

 private:
  GLFWwindow* window_;
};

/// GLFW, its window and ImGui, from the first to the last.
class WindowSystem {
 public:
  explicit WindowSystem(PixelSize size) {
    const auto fail = [](const std::string& what) {
      const char* reason = nullptr;
      glfwGetError(&reason);
      throw RunError("window", what + (reason != nullptr ? std::string(": ") + reason : "") +
                                   "; --headless draws pictures without a window");
    };
#ifdef GLFW_PLATFORM
    // GLFW from 3.4 on tries Wayland first, whose library prints a line where there is none.
    if (std::getenv("WAYLAND_DISPLAY") == nullptr && std::getenv("WAYLAND_SOCKET") == nullptr)
      glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
    if (glfwInit() != GLFW_TRUE) fail("there is no display to open one on");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    window_ = glfwCreateWindow(size.width, size.height, "Cornice", nullptr, nullptr);
    if (window_ == nullptr) {
      glfwTerminate();
      fail("cannot be opened with OpenGL 4.5");
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    require_gl_45();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    // Letters are as sharp as the display allows.
    const auto scale = static_cast<float>(interface_scale(window_));
    ImFontConfig font;
    font.SizePixels = 13.0f * scale;
    ImGui::GetIO().Fonts->AddFontDefault(&font);
    ImGui::GetIO().FontGlobalScale = 1.0f / scale;
#if IMGUI_VERSION_NUM >= 18700
    // Events are shared out among frames before ImGui gets them.
    ImGui::GetIO().ConfigInputTrickleEventQueue = false;
#endif
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 450 core");
  }
  ~WindowSystem() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
  WindowSystem(const WindowSystem&) = delete;
  WindowSystem& operator=(const WindowSystem&) = delete;
  GLFWwindow* get() const { return window_; }

  /// On the whole of the monitor that shows most of the window, and back to where it was.
  void toggle_full_screen() {
    if (glfwGetWindowMonitor(window_) != nullptr) {
      glfwSetWindowMonitor(window_, nullptr, windowed_.x, windowed_.y, windowed_.width,
                           windowed_.height, 0);
      return;
    }
    glfwGetWindowPos(window_, &windowed_.x, &windowed_.y);
    glfwGetWindowSize(window_, &windowed_.width, &windowed_.height);
    int count = 0;
    GLFWmonitor** monitors = glfwGetMonitors(&count);
    std::vector<PixelRectangle> screens;
    for (int i = 0; i < count; ++i) {
      const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
      PixelRectangle& screen = screens.emplace_back();
      glfwGetMonitorPos(monitors[i], &screen.x, &screen.y);
      screen.width = mode->width;
      screen.height = mode->height;
    }
    const auto most = screen_with_most_of(windowed_, screens);
    if (!most) return;
    glfwSetWindowMonitor(window_, monitors[*most], 0, 0, screens[*most].width,
                         screens[*most].height, GLFW_DONT_CARE);
  }

  /// Of the window, also while it fills a screen; screen units.
  PixelSize windowed_size() const {
    if (glfwGetWindowMonitor(window_) != nullptr) return {windowed_.width, windowed_.height};
    PixelSize size;
    glfwGetWindowSize(window_, &size.width, &size.height);
    return size;
  }

  /// Shares its objects with the window's, and must end before it; null where the driver has none.
  std::unique_ptr<SecondContext> second() const {
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    GLFWwindow* hidden = glfwCreateWindow(1, 1, "Cornice", nullptr, window_);
    glfwWindowHint(GLFW_VISIBLE, GLFW_TRUE);
    if (hidden == nullptr) return nullptr;
    auto context = std::make_unique<SecondWindowContext>(hidden);
    const bool works = context->make_current();
    glfwMakeContextCurrent(window_);
    if (!works) return nullptr;
    return context;
  }

 private:
  GLFWwindow* window_ = nullptr;
  PixelRectangle windowed_;  ///< before it filled a screen
};

}  // namespace cornice::viewer
