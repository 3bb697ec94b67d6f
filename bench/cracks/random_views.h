// SPDX-License-Identifier: GPL-3.0-or-later
// Eyes, radii and states of loading at random.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "hlod/select.h"

namespace cornice::bench {

/// Eyes in, on, above and far from the hierarchy, on the borders of cells and beside them.
hlod::FinePoint random_eye(const hlod::Tree& tree, CounterRandom& random);

/// Any radii that obey the rule, as tight as it allows in places.
hlod::Radii random_radii(const hlod::Metric& metric, CounterRandom& random);

/// One byte per cell: the ancestors of what is loaded are loaded.
std::vector<std::uint8_t> random_residency(const hlod::Tree& tree, CounterRandom& random);

}  // namespace cornice::bench
