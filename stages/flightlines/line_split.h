// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts the bins of a survey into passes of the aircraft.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stages/flightlines/pulse_bins.h"

namespace cornice::flightlines {

/// Where the scan runs over the ground: position = start + velocity (t - time) + across tan(angle).
struct TrackFit {
  double time_s = 0.0;  ///< middle of the fitted bins
  Vec3d start;          ///< projected CRS, metres; z is the mean height of the points
  Vec3d velocity;       ///< metres a second, horizontal
  Vec3d across;         ///< metres per unit tangent of the recorded angle, horizontal
  double course_deg = 0.0;
  double course_error_deg = 180.0;
  double speed_error_ms = 1e9;
  double residual_m = 0.0;  ///< robust scale
  std::size_t pulses = 0;
  /// True where the course is known well enough to tell two passes apart by it.
  bool is_reliable() const;
};

/// Robust least squares over the sampled pulses of bins [begin, end), which share a key.
TrackFit fit_track(const std::vector<const PulseBin*>& bins, std::size_t begin, std::size_t end);

/// One pass: bins in time order.
struct LinePass {
  LineKey key;
  std::vector<const PulseBin*> bins;
  bool is_timeless = false;
};

struct SplitOptions {
  double gap_s = 1.5;               ///< longer silence may end a pass
  double sure_gap_s = 20.0;         ///< shorter silence ends one only where the course differs
  double longest_gap_s = 300.0;     ///< longer silence always ends one
  double course_change_deg = 60.0;  ///< ends a pass: no aircraft turns so far in sure_gap_s
  double window_s = 6.0;            ///< course within a pass is judged by windows this long
};

/// What was met on the way.
struct SplitCounts {
  std::size_t gaps_ended = 0;    ///< passes ended by a gap
  std::size_t gaps_bridged = 0;  ///< gaps within a pass
  std::size_t turns_cut = 0;     ///< passes ended by a change of course without a gap
  std::size_t week_rollovers = 0;
  std::size_t constant_times = 0;  ///< keys whose points all carry one time
  std::uint64_t negative_dropped = 0;
  std::uint64_t timeless_dropped = 0;  ///< points without time in lines that have times
};

struct SplitResult {
  std::vector<LinePass> passes;  ///< by first time, then key; timeless ones last
  SplitCounts counts;
};

/// Splits a survey. `set` gets bins changed in place (times across the end of a GPS week continue
/// above 604800; points without a usable time are set apart); the passes point into it.
SplitResult split_lines(BinSet& set, const SplitOptions& options = {});

}  // namespace cornice::flightlines
