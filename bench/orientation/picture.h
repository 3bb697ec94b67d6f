// SPDX-License-Identifier: GPL-3.0-or-later
// Points seen from the side.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/io/raster.h"

namespace cornice::bench {

using Colour = std::array<std::uint8_t, 3>;

/// Parallel view from `azimuth_deg` (where the viewer stands, clockwise from north) and
/// `altitude_deg` above the horizon; every point a square, the nearest wins. `colours` as many as
/// positions.
Picture view(std::span<const Vec3f> positions, std::span<const Colour> colours, double azimuth_deg,
             double altitude_deg, int width);

/// Unit vector from the scene to that viewer.
Vec3f towards_viewer(double azimuth_deg, double altitude_deg);

/// Grey by light from beside the viewer for normals on the right side, red for wrong, yellow for
/// unsettled ones.
std::vector<Colour> colour_by_truth(const std::vector<Vec3f>& normals,
                                    const std::vector<std::uint8_t>& settled,
                                    const std::vector<Vec3f>& truth, Vec3f viewer);

/// Grey as above where the normal faces the viewer, red where it faces away: seen from outside, a
/// surface that hides itself shows red only if it is turned inside out.
std::vector<Colour> colour_by_facing(const std::vector<Vec3f>& normals, Vec3f viewer);

}  // namespace cornice::bench
