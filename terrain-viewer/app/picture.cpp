// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/picture.h"

#include <algorithm>

namespace cornice::viewer {

void resolve(const Target& target, const Target& resolved) {
  const GLint w = target.width(), h = target.height();
  glBlitNamedFramebuffer(target.framebuffer(), resolved.framebuffer(), 0, 0, w, h, 0, 0, w, h,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Picture read_picture(const Target& target) {
  Picture picture;
  picture.width = target.width();
  picture.height = target.height();
  const auto width = static_cast<std::size_t>(picture.width);
  const auto height = static_cast<std::size_t>(picture.height);
  picture.pixels.resize(width * height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(target.colour(), 0, GL_RGB, GL_UNSIGNED_BYTE,
                    static_cast<GLsizei>(picture.pixels.size() * 3), picture.pixels.data());
  // OpenGL's first row is the lowest.
  for (std::size_t row = 0; row < height / 2; ++row)
    std::swap_ranges(
        picture.pixels.begin() + static_cast<std::ptrdiff_t>(row * width),
        picture.pixels.begin() + static_cast<std::ptrdiff_t>((row + 1) * width),
        picture.pixels.begin() + static_cast<std::ptrdiff_t>((height - 1 - row) * width));
  return picture;
}

float read_depth(const Target& target, int x, int y) {
  float depth = 0.0f;
  // OpenGL's first row is the lowest.
  glGetTextureSubImage(target.depth(), 0, x, target.height() - 1 - y, 0, 1, 1, 1,
                       GL_DEPTH_COMPONENT, GL_FLOAT, sizeof depth, &depth);
  return depth;
}

}  // namespace cornice::viewer
