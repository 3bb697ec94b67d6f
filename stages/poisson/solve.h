// SPDX-License-Identifier: GPL-3.0-or-later
// Screened Poisson reconstruction on the lattice of a survey: oriented points in, field out.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/vec.h"
#include "core/mesh/mesh.h"
#include "stages/poisson/field.h"

namespace cornice {

/// What shapes the field. Two tiles meet only where both were solved with the same options.
struct SolveOptions {
  Lattice lattice;  ///< step_m in [0.001, 1000]; time and memory grow with its inverse square
  /// How closely the surface follows each point, against the normals that smooth it; dimensionless,
  /// in [0, 1000]. 0: normals alone (Kazhdan et al. 2006). It holds where the ground bends from
  /// metre to metre; on the finest level, smooth ground takes down to a fifth of it, and bending
  /// ground up to four times as much where points are sparse.
  double point_weight = 8.0;
  /// Points that a cell must see, on average, for its level to be used there; in (0, 100]. Sparser
  /// ground is held on coarser levels.
  double points_per_cell = 0.25;
  int relaxations = 2;  ///< passes whenever a level is visited, in [1, 1000]; time grows with it
  int threads = 0;      ///< 0: all cores; the field does not depend on it
};

/// How one level was solved.
struct LevelReport {
  double spacing_m = 0.0;
  std::uint64_t cells = 0;  ///< that hold points
  std::uint64_t bricks = 0;
  std::uint64_t unknowns = 0;
  double residual = 0.0;  ///< when first solved, over that of zero; both root mean squares
  int passes = 0;         ///< of relaxation, in all
};

struct StepSeconds {
  std::string step;
  double seconds = 0.0;
};

struct SolveReport {
  std::uint64_t points = 0;          ///< used
  std::uint64_t not_finite = 0;      ///< left out: a position, normal or quality that is no number
  std::uint64_t without_normal = 0;  ///< left out: normal or quality is 0
  std::uint64_t outside = 0;         ///< left out: not in the domain
  double field_at_points = 0.0;      ///< mean; how far from 0 screening leaves it
  std::vector<LevelReport> levels;   ///< finest first
  std::vector<StepSeconds> seconds;  ///< by step, in order
};

struct Solution {
  Field field;
  SolveReport report;
};

/// Field of the ground that `points` lie on. Points are in any order; `quality` (empty: 1) weighs
/// them. `domain`, in projected coordinates, bounds the points that count; the field covers it.
/// Beyond and between the points it goes on smoothly. A tile's field depends on what lies within
/// about 40 m of it only, so neighbours that share that much agree.
/// Throws InputError where no point can be used, UsageError for options out of range or a domain
/// of more than 2^31 steps, Cancelled.
/// M. Kazhdan, H. Hoppe, "Screened Poisson surface reconstruction", 2013; M. Kazhdan, M. Bolitho,
/// H. Hoppe, "Poisson surface reconstruction", 2006.
Solution solve_poisson(const OrientedPoints& points, const Box3d& domain,
                       const SolveOptions& options, Progress& progress);

}  // namespace cornice
