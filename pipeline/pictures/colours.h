// SPDX-License-Identifier: GPL-3.0-or-later
// What the demo's pictures are coloured with.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/vec.h"
#include "core/io/raster.h"

namespace cornice::pictures {

using Rgb = std::array<std::uint8_t, 3>;

/// The colour of an ASPRS class; one grey for those without.
Rgb class_colour(std::uint8_t classification);
/// One of many colours that tell neighbours in number apart.
Rgb number_colour(std::uint32_t number);
/// A unit normal as colour: x, y, z from -1..1 as red, green, blue.
Rgb normal_colour(Vec3f normal);
/// Green valley to white summit, for 0..1.
Rgb height_colour(double share);
/// The colour under `light`, where 1 leaves it as it is.
Rgb shaded(Rgb colour, float light);

}  // namespace cornice::pictures
