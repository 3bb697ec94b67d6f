// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/io/raster_file.h"
#include "stages/dem/pixel_rect.h"

namespace cornice::dem {

/// Pixels of the grid of `step` metres through (0, 0) whose centres lie in the raster; a centre on
/// the edge between two rasters is the eastern's, or the southern's.
PixelRect resampled_rect(const RasterHead& head, double step);

/// Heights of the pixels of `part`, which lies in resampled_rect(). Where the new pixels are
/// larger: the mean of bilinear heights spread over the pixel, where half of them have data; else
/// the bilinear height at its centre. A place has a height where the file's pixel that holds it has
/// one. A height depends on the file and its
/// pixel alone, never on `part`. Row i at `to + i * stride`, rows from the north.
void resample(RasterFile& file, const PixelRect& part, double step, float* to, std::size_t stride);

}  // namespace cornice::dem
