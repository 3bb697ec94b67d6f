// SPDX-License-Identifier: GPL-3.0-or-later
// Which bricks lie near samples.
#pragma once

#include <vector>

#include "stages/poisson/samples.h"

namespace cornice::poisson {

/// Bricks of `level`'s grid that may hold a sample within their cells [low, high] (counted from
/// their first cell; low in [-7, 0], high in [7, 15]), sorted; of dense samples only where asked.
/// Some hold none: the test is by the bounding boxes of the samples of each brick.
std::vector<BrickKey> bricks_near(const SampleLevel& level, int low, int high, bool dense_only,
                                  int threads);

}  // namespace cornice::poisson
