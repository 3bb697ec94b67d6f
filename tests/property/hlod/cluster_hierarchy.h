// SPDX-License-Identifier: GPL-3.0-or-later
// Hierarchies by clustering: nothing is asked of a parent but what selection and morphing rely on,
// so meshes fold, meet themselves and vanish as no simplifier would let them.
#pragma once

#include "bench/cracks/checker.h"
#include "core/mesh/mesh.h"

namespace cornice::test {

struct ClusterOptions {
  hlod::Partition partition = hlod::Partition::kQuadtree;
  double root_side_m = 64.0;
  int finest_level = 3;
  int cell_bits = 12;
  double edge_share = 0.25;
  std::uint64_t seed = 1;
};

/// Corner of the root cells at the mesh's origin. Edges must be at most edge_share * the finest
/// cell side. A cell's error is the way that its vertices have come since the finest level.
bench::Hierarchy cluster_hierarchy(const Mesh& mesh, const ClusterOptions& options);

}  // namespace cornice::test
