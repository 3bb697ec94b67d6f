// SPDX-License-Identifier: GPL-3.0-or-later
// Points along a space-filling curve: what lies close together in space lies close in memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace cornice::normals {

/// N points' order along the Morton (Z) curve of their bounding cube, 21 bits an axis.
struct MortonOrder {
  std::vector<std::uint32_t> order;  ///< N; order[rank] = index of the point at that rank
  std::vector<std::uint64_t> keys;   ///< N; of the point at each rank, ascending
};

/// Sorts N < 2^32 finite positions (any frame, metres). Equal keys are sorted by x, y, z, then by
/// index, so coincident points are neighbours in the order and the first of them has the lowest
/// index. The same for any number of threads (0: all cores).
/// G. M. Morton, "A computer oriented geodetic data base", 1966.
MortonOrder sort_along_curve(std::span<const Vec3f> positions, int threads);

/// Keys of positions that are in the order of sort_along_curve already, or of a part of it.
std::vector<std::uint64_t> morton_keys(std::span<const Vec3f> positions, int threads);

}  // namespace cornice::normals
