// SPDX-License-Identifier: GPL-3.0-or-later
// How densely the ground is sampled around each sample.
#pragma once

#include <vector>

#include "stages/poisson/samples.h"

namespace cornice::poisson {

/// Sets area, depth and dense of all samples. levels[0] is the finest, each next one was made by
/// coarser_samples; there is at least one. `points_per_cell` is the density at which a level is
/// fully used, > 0.
/// Kazhdan & Hoppe 2013, section 4.1; Kazhdan et al. 2006, section 4.4.
void estimate_density(std::vector<SampleLevel>& levels, double points_per_cell, int threads);

}  // namespace cornice::poisson
