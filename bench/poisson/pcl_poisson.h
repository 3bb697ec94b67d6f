// SPDX-License-Identifier: GPL-3.0-or-later
// PCL's Poisson reconstruction, as a yardstick.
#pragma once

#include "core/mesh/mesh.h"

namespace cornice::bench {

/// Mesh of the points by pcl::Poisson at `depth` with point weight 4. One thread.
Mesh pcl_poisson(const OrientedPoints& points, int depth);

}  // namespace cornice::bench
