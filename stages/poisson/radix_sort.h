// SPDX-License-Identifier: GPL-3.0-or-later
// Sorting of 64-bit words by some of their bits, in parallel.
#pragma once

#include <cstdint>
#include <vector>

namespace cornice::poisson {

/// Sorts `words` by bits [first_bit, last_bit), 0 <= first_bit <= last_bit <= 64; words that agree
/// in them keep their order. Needs as much memory again. The same for any number of threads.
void radix_sort(std::vector<std::uint64_t>& words, int first_bit, int last_bit, int threads);

}  // namespace cornice::poisson
