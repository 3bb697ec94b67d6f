// SPDX-License-Identifier: GPL-3.0-or-later
// A flight over a hierarchy as the viewer's window flies: one frame each 1/60 s, cells read by
// threads of their own meanwhile. Nothing is drawn, so that a rasteriser in software does not
// count.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "terrain-viewer/render/offscreen_context.h"

namespace cornice::bench {

struct FlightOptions {
  double seconds = 60.0;
  double speed_ms = 100.0;
  double error_pixels = 0.2;  ///< about 1000 cells of the made ground
  std::uint64_t gpu_bytes = 1ull << 30, cache_bytes = 1ull << 30;
  bool makes_room_ahead = true;  ///< on the GPU, by a thread of its own
};

/// What one frame took of the thread that draws, and what else happened meanwhile.
struct FlightFrame {
  double ms = 0.0;      ///< choosing, streaming and uploading
  double cpu_ms = 0.0;  ///< of the same thread's processor time
  std::uint64_t cells = 0, triangles = 0;
  std::uint64_t missing = 0;  ///< cells that the view needed and that were not there
  std::uint64_t uploaded_bytes = 0;
  std::int64_t page_faults = 0;  ///< of this thread that needed no disk
  std::int64_t waits = 0;        ///< times that the thread gave the processor up
  std::int64_t displaced = 0;    ///< times that it had to
  /// Hundredths of a second that the host took from a virtual machine, all processors, from the
  /// frame before on; always 0 where the system does not tell.
  std::int64_t stolen_ticks = 0;
};

/// All frames, and what was held at most.
struct FlightResult {
  std::vector<FlightFrame> frames;
  double read_bytes = 0;
  double gpu_over_budget = 0, cache_over_budget = 0;  ///< largest share
  double waited_for_mb = 0;  ///< room on the GPU that the thread that draws made itself
};

/// On the thread of the context.
FlightResult fly_over(const std::filesystem::path& file, const FlightOptions& options,
                      const viewer::OffscreenContext& context);

}  // namespace cornice::bench
