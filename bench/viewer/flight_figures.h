// SPDX-License-Identifier: GPL-3.0-or-later
// Figures of flights. A frame that the machine held up is slow in one flight, one that has too much
// to do is slow in each: so the same way is flown several times, and frames are compared by their
// place in it.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "bench/bench_json.h"
#include "bench/viewer/flight.h"

namespace cornice::bench {

/// Of flights over the same way: times as they were in the first, and the least that each frame
/// took in any.
void flight_figures(std::span<const FlightResult> flights, Result& result);

/// One line of comma-separated values for each frame of each flight.
void write_frames(const std::filesystem::path& path, std::span<const FlightResult> flights);

}  // namespace cornice::bench
