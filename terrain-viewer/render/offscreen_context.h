// SPDX-License-Identifier: GPL-3.0-or-later
// OpenGL without a window or a display, through EGL.
#pragma once

#include <memory>
#include <string>

namespace cornice::viewer {

/// A current OpenGL 4.5 core context on this thread, on the GPU or on Mesa's software rasteriser.
class OffscreenContext {
 public:
  /// Throws RunError, saying what is missing, where there is no EGL or no OpenGL 4.5.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// "renderer, version" of the current context.
std::string gl_description();

/// Throws RunError where the current context is older than OpenGL 4.5.
void require_gl_45();

}  // namespace cornice::viewer
