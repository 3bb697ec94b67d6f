// SPDX-License-Identifier: GPL-3.0-or-later
// Differences as colours.
#pragma once

#include <array>
#include <cstdint>

namespace cornice::compare {

using Rgb = std::array<std::uint8_t, 3>;

/// Red where B lies below A, nearly white at zero, blue above; full at +-range. Yellow for NaN.
Rgb difference_colour(double difference_m, double range_m);
/// What is surface below the horizon.
inline constexpr Rgb kOverhangColour{190, 60, 200};
inline constexpr Rgb kGroundColour{214, 208, 198};
inline constexpr Rgb kUnknownColour{240, 214, 90};
/// The colour under `light`; 1 leaves it as it is.
Rgb lit(Rgb colour, double light);

}  // namespace cornice::compare
