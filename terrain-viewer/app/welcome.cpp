// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/welcome.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "core/cli/log.h"
#include "terrain-viewer/app/dropped_files.h"
#include "terrain-viewer/app/frame_pacer.h"

namespace cornice::viewer {
namespace {

namespace fs = std::filesystem;

struct Dropped {
  std::vector<fs::path> files;
  std::string problem;  ///< of those dropped last
};

/// The hierarchies among them; without one a problem.
void take(Dropped& dropped, const std::vector<fs::path>& paths) {
  for (const fs::path& path : without_folders(paths))
    if (path.extension() == ".hlod") dropped.files.push_back(path);
  if (dropped.files.empty() && !paths.empty())
    dropped.problem = paths.front().filename().string() + " is no hierarchy (.hlod)";
}

void draw_welcome(const std::string& problem) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * size.x, 0.5f * size.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::Begin("Cornice", nullptr,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  ImGui::TextUnformatted(
      "Drop a hierarchy (.hlod) here to look at it.\n\n"
      "From the command line:    cornice-viewer survey.hlod\n"
      "To make one of a mesh:    cornice-hlod build mesh.ply -o survey.hlod\n"
      "Of a survey's tiles:      cornice run survey.yaml\n\n"
      "F1 lists what keys and the mouse do, once there is something to see.\n"
      "Next time the latest file opens by itself. Ctrl+Q ends.");
  if (!problem.empty()) {
    ImGui::Separator();
    ImGui::TextColored({1.0f, 0.75f, 0.4f, 1.0f}, "%s", problem.c_str());
  }
  ImGui::End();
}

void draw_frame(GLFWwindow* window, const std::string& problem) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  use_interface_scale(window);
  ImGui::NewFrame();
  draw_welcome(problem);
  ImGui::Render();
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width, height);
  glClearColor(0.66f, 0.76f, 0.88f, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window);
}

/// What the window was asked for while it waited.
struct Asked {
  std::vector<fs::path> paths;
  bool is_news = false;
};

Asked& asked_of(GLFWwindow* window) {
  return *static_cast<Asked*>(glfwGetWindowUserPointer(window));
}

void listen(GLFWwindow* window, Asked& asked) {
  glfwSetWindowUserPointer(window, &asked);
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** names) {
    asked_of(w) = {{names, names + count}, true};
  });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { asked_of(w).is_news = true; });
  glfwSetFramebufferSizeCallback(window,
                                 [](GLFWwindow* w, int, int) { asked_of(w).is_news = true; });
}

void listen_no_more(GLFWwindow* window) {
  glfwSetDropCallback(window, nullptr);
  glfwSetWindowRefreshCallback(window, nullptr);
  glfwSetFramebufferSizeCallback(window, nullptr);
  glfwSetWindowUserPointer(window, nullptr);
}

bool wants_to_end(GLFWwindow* window) {
  const bool has_control = glfwGetKey(window, GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS ||
                           glfwGetKey(window, GLFW_KEY_RIGHT_CONTROL) == GLFW_PRESS;
  return glfwWindowShouldClose(window) != GLFW_FALSE ||
         (has_control && glfwGetKey(window, GLFW_KEY_Q) == GLFW_PRESS);
}

}  // namespace

std::vector<fs::path> ask_for_files(WindowSystem& window, const Progress& progress,
                                    const std::string& problem) {
  // Between two looks at whether the process is told to end.
  constexpr double kWaitS = 0.1;
  Dropped dropped{{}, problem};
  Asked asked;
  FramePacer pacer(glfwGetTime());
  listen(window.get(), asked);
  std::uint64_t frames = 0;
  while (dropped.files.empty() && !wants_to_end(window.get()) && !progress.cancelled()) {
    if (pacer.next(glfwGetTime())) {
      draw_frame(window.get(), dropped.problem);
      pacer.drawn(false, false);
      ++frames;
      if (!pacer.is_awake()) log_debug("waits after " + std::to_string(frames) + " frames");
    }
    if (pacer.is_awake())
      glfwPollEvents();
    else
      glfwWaitEventsTimeout(kWaitS);
    if (std::exchange(asked.is_news, false)) pacer.wake();
    take(dropped, std::exchange(asked.paths, {}));
  }
  listen_no_more(window.get());
  return std::move(dropped.files);
}

}  // namespace cornice::viewer
