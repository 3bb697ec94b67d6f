// SPDX-License-Identifier: GPL-3.0-or-later
// How long the GPU takes, without waiting for it.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "terrain-viewer/render/gl.h"

namespace cornice::viewer {

/// Times what is drawn between begin and end; the answer comes some frames later. For the thread of
/// the context.
class GpuTimer {
 public:
  GpuTimer();
  void begin();
  void end();
  /// Milliseconds of the earliest begin..end that the GPU has done since the last call.
  std::optional<double> take();

 private:
  static constexpr std::size_t kInFlight = 4;
  std::array<GlQuery, kInFlight> queries_;
  std::size_t first_ = 0, count_ = 0;
  bool runs_ = false;
};

}  // namespace cornice::viewer
