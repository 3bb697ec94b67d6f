// SPDX-License-Identifier: GPL-3.0-or-later
// Fields made from functions, for the tests of extraction and bands.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/topology.h"
#include "stages/poisson/extract.h"

namespace cornice::test {

/// Value at a place given in lattice steps.
using Function = std::function<float(double x, double y, double z)>;

/// Bricks of level 0 to cover, both ends included.
struct BrickBox {
  BrickKey first, last;
};

/// `function` on all nodes of `box` at level 0.
Field sampled(const Function& function, const BrickBox& box, double step_m = 0.5);

/// The same with levels 0 to `levels` - 1: the coarsest everywhere, finer bricks where
/// keep(level, brick) says so.
Field sampled_adaptively(const Function& function, const BrickBox& box, int levels,
                         const std::function<bool(int level, BrickKey brick)>& keep,
                         double step_m = 0.5);

/// Values on nodes drawn uniformly from [-1, 1]: the hardest field there is.
Function white_noise(std::uint64_t seed);
/// Sum of `waves` plane waves of wavelengths around `wavelength` steps.
Function smooth_noise(std::uint64_t seed, double wavelength, int waves = 12);

/// The window's cells and a weld that the tests share.
ExtractOptions window_options(LatticeBox window, int threads = 2, double weld = 0.2);

/// Checks that a surface is manifold, that its open edges lie on the window's border planes (within
/// them, where `closed`, none), and that all numbers are finite and lie on the lattice of units.
void expect_sound(const Surface& surface, const Lattice& lattice, const LatticeBox& window);

}  // namespace cornice::test
