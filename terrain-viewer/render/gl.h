// SPDX-License-Identifier: GPL-3.0-or-later
// OpenGL objects as values that end by themselves. For .cpp files of the renderer; every function
// and destructor needs the context that made the object to be current.
#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace cornice::viewer {

/// A GL name and what deletes it.
template <void (*Delete)(GLuint)>
class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(GLuint id) : id_(id) {}
  GlObject(GlObject&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~GlObject() {
    if (id_ != 0) Delete(id_);
  }
  GLuint id() const { return id_; }

 private:
  GLuint id_ = 0;
};

inline void delete_buffer(GLuint id) { glDeleteBuffers(1, &id); }
inline void delete_texture(GLuint id) { glDeleteTextures(1, &id); }
inline void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
inline void delete_vertex_array(GLuint id) { glDeleteVertexArrays(1, &id); }
inline void delete_program(GLuint id) { glDeleteProgram(id); }
inline void delete_query(GLuint id) { glDeleteQueries(1, &id); }

using GlBuffer = GlObject<delete_buffer>;
using GlTexture = GlObject<delete_texture>;
using GlFramebuffer = GlObject<delete_framebuffer>;
using GlVertexArray = GlObject<delete_vertex_array>;
using GlProgram = GlObject<delete_program>;
using GlQuery = GlObject<delete_query>;

/// Storage of a fixed size that may be written with glNamedBufferSubData. Throws RunError where the
/// GPU has no room for it.
GlBuffer make_buffer(std::size_t bytes);
GlVertexArray make_vertex_array();

/// Compiles and links. Throws RunError with the driver's log, which is a fault of the program.
/// captured: outputs of the vertex shader that transform feedback is to write.
GlProgram make_program(const std::string& name, const char* vertex_source,
                       const char* fragment_source, const std::vector<const char*>& captured = {});

/// Colours and depths to draw into: RGBA8 and 32-bit float depth.
class Target {
 public:
  /// samples: 1, or the number of samples per pixel.
  Target(int width, int height, int samples);
  int width() const { return width_; }
  int height() const { return height_; }
  GLuint framebuffer() const { return framebuffer_.id(); }
  GLuint colour() const { return colour_.id(); }
  GLuint depth() const { return depth_.id(); }

 private:
  int width_, height_;
  GlTexture colour_, depth_;
  GlFramebuffer framebuffer_;
};

}  // namespace cornice::viewer
