// SPDX-License-Identifier: GPL-3.0-or-later
// How near pictures of chosen detail are to those of the finest mesh alone.
#pragma once

#include <cstdint>
#include <filesystem>

#include "bench/bench_json.h"

namespace cornice::bench {

/// Six views in a hierarchy, `picture_...`, and four of all of it, `far_picture_...`, for an error
/// of 2 pixels, with an OpenGL context on this thread: as the viewer draws them; drawn with 4 x 4
/// as many pixels and averaged, which tells what of the difference is in the light of single
/// pixels; and of the finest mesh against itself a quarter of a pixel up, which is what the
/// yardstick itself is good for.
void measure_likeness(const std::filesystem::path& file, std::uint64_t seed, Result& result);

}  // namespace cornice::bench
