// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/overlay.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "core/base/error.h"

namespace cornice::viewer {

Overlay::Overlay(int scale) : scale_(static_cast<float>(scale)) {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  ImFontConfig font;
  font.SizePixels = 13.0f * scale_;
  io.Fonts->AddFontDefault(&font);
  io.FontGlobalScale = 1.0f / scale_;
  if (ImGui_ImplOpenGL3_Init("#version 450 core")) return;
  ImGui::DestroyContext();
  throw RunError("OpenGL", "cannot draw a legend: its library, libGL.so.1, is not there");
}

Overlay::~Overlay() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void Overlay::draw(const Target& target, const std::function<void()>& panels) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {float(target.width()) / scale_, float(target.height()) / scale_};
  io.DisplayFramebufferScale = {scale_, scale_};
  // Nothing may depend on the time between pictures.
  io.DeltaTime = 1.0f / 60.0f;
  for (int round = 0; round < 2; ++round) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    panels();
    ImGui::Render();
  }
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  glViewport(0, 0, target.width(), target.height());
  glDisable(GL_DEPTH_TEST);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace cornice::viewer
