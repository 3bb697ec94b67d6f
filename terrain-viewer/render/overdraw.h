// SPDX-License-Identifier: GPL-3.0-or-later
// How often each pixel is drawn: fragments that pass the depth test, counted and shown in colours.
#pragma once

#include <memory>

#include "terrain-viewer/render/gl.h"

namespace cornice::viewer {

/// Li, "Multi-resolution rendering of LiDAR terrain", thesis, 2024, 4.4.4. One sample per pixel.
class Overdraw {
 public:
  Overdraw();
  /// What is drawn from here to show(), with program(), is counted. Viewport: width x height.
  void begin(int width, int height);
  GLuint program() const { return count_program_.id(); }
  /// Draws the counts' colours, and the depths, into a part of a framebuffer from column `left` on.
  /// Returns fragments per pixel that shows something: 1 where nothing is drawn twice, 0 where
  /// nothing is drawn. Waits for the GPU.
  double show(GLuint framebuffer, int left);

 private:
  GlProgram count_program_, show_program_;
  GlVertexArray array_;
  GlTexture counts_;
  std::unique_ptr<Target> target_;
};

}  // namespace cornice::viewer
