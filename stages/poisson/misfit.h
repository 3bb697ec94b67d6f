// SPDX-License-Identifier: GPL-3.0-or-later
// How firmly ground is to be held, from how a field that held it loosely misses the samples.
#pragma once

#include <span>
#include <vector>

#include "stages/poisson/closed_brick.h"
#include "stages/poisson/samples.h"

namespace cornice::poisson {

/// What smooth ground is held with, of what bending ground with a point in every finest cell is.
inline constexpr float kLoosePull = 0.2f;

/// The field at every sample of a level, in their order; 0 where no level covers one. levels[0] is
/// of the samples' own spacing.
std::vector<float> fields_at_samples(const SampleLevel& samples, std::span<const LevelView> levels,
                                     int threads);

/// Lowers the pull of samples[0], down to kLoosePull of its area, where a field that was held with
/// that misses them as noise does. What samples within two steps miss alike is ground that bends
/// faster than the field; what each misses by itself is noise, and a firmer hold would follow it.
/// `fields` are that field's, as fields_at_samples() gives them; samples[2] must be there. Looks at
/// fixed cells within 16 steps, so that a tile and its neighbour find the same.
/// A local form of V. A. Morozov's discrepancy principle (1966).
void loosen_pull(std::span<SampleLevel> samples, const std::vector<float>& fields, int threads);

}  // namespace cornice::poisson
