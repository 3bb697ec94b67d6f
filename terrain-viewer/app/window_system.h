// SPDX-License-Identifier: GPL-3.0-or-later
// The window with its OpenGL 4.5 and Dear ImGui. For the one file that has a window.
#pragma once

#include <epoxy/gl.h>
// After epoxy, which brings OpenGL's declarations.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <memory>
#include <string>

#include "core/base/error.h"
#include "terrain-viewer/app/options.h"
#include "terrain-viewer/render/cell_page.h"
#include "terrain-viewer/render/offscreen_context.h"

namespace cornice::viewer {

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
    // A key of flying that goes down and up between two slow frames still counts.
    glfwSetInputMode(window_, GLFW_STICKY_KEYS, GLFW_TRUE);
    require_gl_45();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
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
};

}  // namespace cornice::viewer
