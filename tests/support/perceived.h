// SPDX-License-Identifier: GPL-3.0-or-later
// How different two pictures look.
#pragma once

#include "core/io/raster.h"

namespace cornice::test {

/// Colour differences as the eye sees them: CIE 1976, Euclidean in L*a*b*, of both pictures blurred
/// by a Gaussian of 1.2 pixels, for what is finer than that is not looked at one by one. About 2.3
/// is just noticeable side by side.
struct Perceived {
  double mean = 0.0;
  double p99 = 0.0;  ///< 99 of 100 pixels differ less
};

/// Both of one size. ISO/CIE 11664-4, white point D65; sRGB by IEC 61966-2-1.
Perceived perceived_difference(const Picture& a, const Picture& b);

}  // namespace cornice::test
