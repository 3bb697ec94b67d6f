// SPDX-License-Identifier: GPL-3.0-or-later
// One reconstruction by our engine, and how far each of its steps is from what two cores can do.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "stages/poisson/solve.h"

namespace cornice::bench {

struct Run {
  Mesh mesh;
  SolveReport report;
  double solve_s = 0.0, extract_s = 0.0;
  double cpu_s = 0.0;  ///< of all threads, both
  double gib = 0.0;    ///< most memory the process has held until now, points included
  double seconds() const { return solve_s + extract_s; }
};

/// Mesh of the points at a lattice step, in memory. The domain is the box of the points.
Run reconstruct(const OrientedPoints& points, double step_m, int threads);

/// A step beside the seconds it would take if nothing but the memory (14 GB/s), or in solving
/// nothing but a 27-point stencil (450 M nodes/s), held it up.
struct StepBound {
  std::string step;
  double seconds = 0.0, bound_s = 0.0;
};
std::vector<StepBound> step_bounds(const Run& run);

/// One line for the whole and a table of its steps.
void print(const Run& run, const std::string& name);

}  // namespace cornice::bench
