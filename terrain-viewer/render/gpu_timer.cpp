// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/gpu_timer.h"

namespace cornice::viewer {

GpuTimer::GpuTimer() {
  for (GlQuery& query : queries_) {
    GLuint id = 0;
    glCreateQueries(GL_TIME_ELAPSED, 1, &id);
    query = GlQuery(id);
  }
}

void GpuTimer::begin() {
  // With all in flight this frame goes untimed.
  runs_ = count_ < kInFlight;
  if (runs_) glBeginQuery(GL_TIME_ELAPSED, queries_[(first_ + count_) % kInFlight].id());
}

void GpuTimer::end() {
  if (!runs_) return;
  glEndQuery(GL_TIME_ELAPSED);
  ++count_;
  runs_ = false;
}

std::optional<double> GpuTimer::take() {
  if (count_ == 0) return std::nullopt;
  const GLuint query = queries_[first_].id();
  GLint is_done = GL_FALSE;
  glGetQueryObjectiv(query, GL_QUERY_RESULT_AVAILABLE, &is_done);
  if (is_done != GL_TRUE) return std::nullopt;
  GLuint64 nanoseconds = 0;
  glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
  first_ = (first_ + 1) % kInFlight;
  --count_;
  return static_cast<double>(nanoseconds) * 1e-6;
}

}  // namespace cornice::viewer
