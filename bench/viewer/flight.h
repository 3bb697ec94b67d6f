// SPDX-License-Identifier: GPL-3.0-or-later
// A flight over a hierarchy as the viewer's window flies: one frame each 1/60 s, cells read by
// threads of their own meanwhile. Nothing is drawn, so that a rasteriser in software does not
// count.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace cornice::bench {

struct FlightOptions {
  double seconds = 60.0;
  double speed_ms = 100.0;
  double error_pixels = 0.5;  ///< about 1000 cells of the made ground
  std::uint64_t gpu_bytes = 1ull << 30, cache_bytes = 1ull << 30;
};

/// One entry a frame, and what was held at most.
struct FlightResult {
  std::vector<double> ms;      ///< choosing, streaming and uploading
  std::vector<double> cpu_ms;  ///< of the same thread's processor time
  std::vector<double> cells, triangles;
  std::vector<double> missing;  ///< cells that the view needed
  double uploaded_bytes = 0, read_bytes = 0;
  double gpu_over_budget = 0, cache_over_budget = 0;  ///< largest share
};

/// With an OpenGL context on this thread.
FlightResult fly_over(const std::filesystem::path& file, const FlightOptions& options);

}  // namespace cornice::bench
