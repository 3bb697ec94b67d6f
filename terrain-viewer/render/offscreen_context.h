// SPDX-License-Identifier: GPL-3.0-or-later
// OpenGL without a window or a display, through EGL.
#pragma once

#include <memory>
#include <string>

#include "terrain-viewer/render/cell_page.h"

namespace cornice::viewer {

/// A current OpenGL 4.5 core context on this thread, on the GPU or on Mesa's software rasteriser.
class OffscreenContext {
 public:
  /// Throws RunError, saying what is missing, where there is no EGL or no OpenGL 4.5.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// One that shares its objects with this; ends before it. Null where the driver has none.
  std::unique_ptr<SecondContext> second() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// "renderer, version" of the current context.
std::string gl_description();

/// Throws RunError where the current context is older than OpenGL 4.5.
void require_gl_45();

}  // namespace cornice::viewer
