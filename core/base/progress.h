// SPDX-License-Identifier: GPL-3.0-or-later
// What a long function tells its caller. The default does nothing and never cancels.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/base/error.h"

namespace cornice {

/// Progress of one step at a time. Implementations must allow advance() from several threads.
class Progress {
 public:
  virtual ~Progress() = default;
  /// Starts a step of `total` units of work (0: not known).
  virtual void begin(std::string_view /*step*/, std::uint64_t /*total*/) {}
  /// Adds work done. Call a bounded number of times, not once per point.
  virtual void advance(std::uint64_t /*work*/) {}
  virtual void end() {}
  /// True once the caller wants the work to stop; long loops check it and throw Cancelled.
  virtual bool cancelled() const { return false; }
};

/// Throws Cancelled where the caller wants the work to stop.
inline void check_cancelled(const Progress& progress) {
  if (progress.cancelled()) throw Cancelled();
}

/// A Progress that does nothing, for defaults.
inline Progress& no_progress() {
  static Progress none;
  return none;
}

}  // namespace cornice
