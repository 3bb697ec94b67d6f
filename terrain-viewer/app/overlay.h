// SPDX-License-Identifier: GPL-3.0-or-later
// Panels over a picture that no window shows (Dear ImGui).
#pragma once

#include <functional>

#include "terrain-viewer/render/gl.h"

namespace cornice::viewer {

/// One at a time, on the thread of its OpenGL context, which must be current from its making to its
/// end.
class Overlay {
 public:
  /// scale: pixels of the picture for one of a panel. Throws RunError where Dear ImGui finds no
  /// OpenGL to draw with.
  explicit Overlay(int scale = 1);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  /// Draws what `panels` does over the target, of one sample. Called twice: panels that fit
  /// themselves to what is in them have their size the second time only.
  void draw(const Target& target, const std::function<void()>& panels);

 private:
  float scale_;
};

}  // namespace cornice::viewer
