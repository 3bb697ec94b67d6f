// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/gl.h"

#include <array>

#include "core/base/error.h"
#include "terrain-viewer/render/shaders.h"

namespace cornice::viewer {
namespace {

GLuint compile(GLenum kind, const std::string& name, const char* source) {
  const GLuint shader = glCreateShader(kind);
  const std::array<const char*, 4> parts{"#version 450 core\n", shaders::kFrame, "\n#line 1\n",
                                         source};
  glShaderSource(shader, static_cast<GLsizei>(parts.size()), parts.data(), nullptr);
  glCompileShader(shader);
  GLint done = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  std::array<char, 2048> log{};
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  glDeleteShader(shader);
  throw RunError("shader " + name, std::string("does not compile: ") + log.data());
}

}  // namespace

GlBuffer make_buffer(std::size_t bytes) {
  GLuint id = 0;
  glCreateBuffers(1, &id);
  GlBuffer buffer(id);
  while (glGetError() != GL_NO_ERROR) {
  }
  glNamedBufferStorage(id, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
  if (glGetError() == GL_OUT_OF_MEMORY)
    throw RunError("GPU", "has no room for " + std::to_string(bytes >> 20) +
                              " MiB; give a smaller --gpu-memory-mib");
  return buffer;
}

GlVertexArray make_vertex_array() {
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  return GlVertexArray(id);
}

GlProgram make_program(const std::string& name, const char* vertex_source,
                       const char* fragment_source, const std::vector<const char*>& captured) {
  const GLuint vertex = compile(GL_VERTEX_SHADER, name + " (vertices)", vertex_source);
  const GLuint fragment = compile(GL_FRAGMENT_SHADER, name + " (fragments)", fragment_source);
  GlProgram program(glCreateProgram());
  glAttachShader(program.id(), vertex);
  glAttachShader(program.id(), fragment);
  if (!captured.empty())
    glTransformFeedbackVaryings(program.id(), static_cast<GLsizei>(captured.size()),
                                captured.data(), GL_INTERLEAVED_ATTRIBS);
  glLinkProgram(program.id());
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  GLint done = GL_FALSE;
  glGetProgramiv(program.id(), GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return program;
  std::array<char, 2048> log{};
  glGetProgramInfoLog(program.id(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw RunError("shader " + name, std::string("does not link: ") + log.data());
}

Target::Target(int width, int height, int samples) : width_(width), height_(height) {
  const GLenum kind = samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
  const auto texture = [&](GLenum format) {
    GLuint id = 0;
    glCreateTextures(kind, 1, &id);
    if (samples > 1)
      glTextureStorage2DMultisample(id, samples, format, width, height, GL_TRUE);
    else
      glTextureStorage2D(id, 1, format, width, height);
    return GlTexture(id);
  };
  colour_ = texture(GL_RGBA8);
  depth_ = texture(GL_DEPTH_COMPONENT32F);
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  framebuffer_ = GlFramebuffer(id);
  glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, colour_.id(), 0);
  glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth_.id(), 0);
  if (glCheckNamedFramebufferStatus(id, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw RunError("GPU", "cannot draw into a picture of " + std::to_string(width) + " x " +
                              std::to_string(height) + " pixels");
}

}  // namespace cornice::viewer
