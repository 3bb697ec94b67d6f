// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/overdraw.h"

#include <array>
#include <cstdint>
#include <vector>

#include "terrain-viewer/render/shaders.h"
#include "terrain-viewer/scene/ramp.h"

namespace cornice::viewer {
namespace {

/// As in shaders/overdraw_colours.frag.
constexpr std::size_t kColours = 9;

}  // namespace

Overdraw::Overdraw()
    : count_program_(make_program("overdraw", shaders::kSurfaceVertex, shaders::kOverdrawFragment)),
      show_program_(
          make_program("overdraw colours", shaders::kSkyVertex, shaders::kOverdrawColoursFragment)),
      array_(make_vertex_array()) {
  const Ramp ramp = overdraw_ramp();
  std::array<float, 3 * kColours> colours{};
  for (std::size_t i = 0; i < kColours; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      colours[3 * i + c] = float(ramp.stops[i].colour[c]) / 255.0f;
  glProgramUniform3fv(show_program_.id(), glGetUniformLocation(show_program_.id(), "colours"),
                      kColours, colours.data());
}

void Overdraw::begin(int width, int height) {
  if (!target_ || target_->width() != width || target_->height() != height) {
    target_ = std::make_unique<Target>(width, height, 1);
    GLuint id = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &id);
    counts_ = GlTexture(id);
    glTextureStorage2D(id, 1, GL_R32UI, width, height);
    // Whole numbers cannot be mixed: with the default filter there would be nothing to read.
    for (const GLenum which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      glTextureParameteri(id, which, GL_NEAREST);
  }
  const GLuint none = 0;
  glClearTexImage(counts_.id(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
  glBindImageTexture(0, counts_.id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
  glBindFramebuffer(GL_FRAMEBUFFER, target_->framebuffer());
  glViewport(0, 0, width, height);
  glClear(GL_DEPTH_BUFFER_BIT);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
}

double Overdraw::show(GLuint framebuffer, int left) {
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                  GL_TEXTURE_FETCH_BARRIER_BIT);
  const int width = target_->width(), height = target_->height();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(left, 0, width, height);
  glUseProgram(show_program_.id());
  glUniform1i(glGetUniformLocation(show_program_.id(), "left"), left);
  glBindTextureUnit(0, counts_.id());
  glBindTextureUnit(1, target_->depth());
  glBindVertexArray(array_.id());
  glDepthFunc(GL_ALWAYS);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthFunc(GL_GREATER);
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(width) *
                                    static_cast<std::size_t>(height));
  glGetTextureImage(counts_.id(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT,
                    static_cast<GLsizei>(counts.size() * sizeof counts[0]), counts.data());
  std::uint64_t fragments = 0, pixels = 0;
  for (const std::uint32_t count : counts) {
    fragments += count;
    pixels += count > 0 ? 1 : 0;
  }
  return pixels > 0 ? static_cast<double>(fragments) / static_cast<double>(pixels) : 0.0;
}

}  // namespace cornice::viewer
