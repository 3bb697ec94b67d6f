// SPDX-License-Identifier: GPL-3.0-or-later
// What is looked at for cracks: hierarchies of an elevation model, a cliff and an overhang.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/cracks/checker.h"

namespace cornice::bench {

struct Subject {
  std::string name;
  Hierarchy hierarchy;
};

/// Ground of `scene` (the cliff) and of formulas, sides of about size_m, triangles of about 1 m:
/// each as a quadtree and as an octree, built as cornice-hlod builds.
std::vector<Subject> made_subjects(const std::filesystem::path& scene, double size_m,
                                   std::uint64_t seed, int threads);

}  // namespace cornice::bench
