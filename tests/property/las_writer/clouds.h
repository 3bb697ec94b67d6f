// SPDX-License-Identifier: GPL-3.0-or-later
// Made-up points with every field filled, and what LASzip should read of them.
#pragma once

#include <cstdint>
#include <vector>

#include "core/io/las.h"
#include "tests/property/las_writer/laszip_oracle.h"

namespace cornice::test {

/// Several attributes of different types, 15 bytes together.
std::vector<ExtraByte> sample_extra_bytes();

/// `count` points over about `side` metres at the offset of `options`, different for each seed;
/// every attribute filled within what the point format can hold, `exact` too.
PointCloud sample_cloud(std::size_t count, const LasWriteOptions& options, std::uint64_t seed,
                        double side = 1000.0);

/// The points as a reader of the format should find them.
std::vector<OraclePoint> expected_points(const PointCloud& cloud, const LasWriteOptions& options);

}  // namespace cornice::test
