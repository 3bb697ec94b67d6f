// SPDX-License-Identifier: GPL-3.0-or-later
// Rasters of heights seen from straight above.
#pragma once

#include <vector>

#include "core/io/raster.h"
#include "core/points/flight_line.h"

namespace cornice::pictures {

/// Neighbouring rasters of one step as one; holes between them hold no data. Not empty.
/// Throws InputError where a raster's step or grid differs from the first one's.
Raster merged(const std::vector<Raster>& parts);

/// Hillshade tinted by height, one pixel per raster pixel; white where there is no data.
Picture relief_picture(const Raster& raster);

/// Draws the sensor's path of each line over a picture of `raster`, as far as it lies above it;
/// `margin_px` is the white border that `with_margin` gave the picture.
void draw_trajectories(Picture& picture, const Raster& raster, const FlightLines& lines,
                       int margin_px);

/// The picture inside a white border.
Picture with_margin(const Picture& picture, int margin_px);

}  // namespace cornice::pictures
