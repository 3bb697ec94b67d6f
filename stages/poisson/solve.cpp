// SPDX-License-Identifier: GPL-3.0-or-later
// Level by level, coarse to fine: M. Kazhdan, H. Hoppe, "Screened Poisson surface reconstruction",
// 2013, section 3, with trilinear functions. As their spaces are nested, a level's unknowns are the
// whole field there, not what it adds to coarser ones.
#include "stages/poisson/solve.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "stages/poisson/composite.h"
#include "stages/poisson/constraints.h"
#include "stages/poisson/density.h"
#include "stages/poisson/grid.h"
#include "stages/poisson/misfit.h"
#include "stages/poisson/relax.h"
#include "stages/poisson/samples.h"
#include "stages/poisson/screening.h"

namespace cornice {
namespace {

using namespace poisson;

/// From this level on (32 m at 0.5 m) the grid covers the whole domain. The same for all tiles of a
/// survey, whatever their size.
constexpr int kFirstWhole = 6;
/// Coarsening ends where the domain is this many bricks wide.
constexpr int kCoarsestBricks = 2;
/// The whole levels are small; they are relaxed more, as they have farther to carry.
constexpr int kWholeFactor = 8;

void check(const SolveOptions& options) {
  const auto refuse = [](const char* option, const char* range) {
    throw UsageError(option, std::string("must be ") + range);
  };
  if (!(options.lattice.step_m >= 0.001 && options.lattice.step_m <= 1000.0))
    refuse("--step", "in [0.001, 1000] m");
  if (!(options.point_weight >= 0.0 && options.point_weight <= 1000.0))
    refuse("--point-weight", "in [0, 1000]");
  if (!(options.points_per_cell > 0.0 && options.points_per_cell <= 100.0))
    refuse("--points-per-cell", "above 0 and at most 100");
  if (options.relaxations < 1 || options.relaxations > 1000)
    refuse("--relaxations", "in [1, 1000]");
}

/// Times steps and tells them to whoever watches.
class Steps {
 public:
  Steps(Progress& progress, SolveReport& report) : progress_(progress), report_(report) {}
  template <class Work>
  auto operator()(const char* name, Work work) {
    check_cancelled(progress_);
    progress_.begin(name, 0);
    const auto start = std::chrono::steady_clock::now();
    struct End {
      Steps& steps;
      const char* name;
      std::chrono::steady_clock::time_point start;
      ~End() {
        const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
        steps.progress_.end();
        steps.report_.seconds.push_back({name, time.count()});
      }
    } end{*this, name, start};
    return work();
  }

 private:
  Progress& progress_;
  SolveReport& report_;
};

/// Box of bricks of level kFirstWhole around all finer levels: their bricks reach less than one
/// brick beyond the samples', and the far faces of that one belong to the next.
BrickBox whole_box(const SampleLevel& samples) {
  BrickBox box{samples.bricks.front(), samples.bricks.front()};
  for (const BrickKey b : samples.bricks) {
    box.first = {std::min(box.first.x, b.x), std::min(box.first.y, b.y),
                 std::min(box.first.z, b.z)};
    box.last = {std::max(box.last.x, b.x), std::max(box.last.y, b.y), std::max(box.last.z, b.z)};
  }
  return {shifted(box.first, -1, -1, -1), shifted(box.last, 2, 2, 2)};
}

/// The next coarser box, with room for the far faces of this one.
BrickBox coarser(const BrickBox& box) {
  return {parent(box.first), parent(shifted(box.last, 1, 1, 1))};
}

int widest(const BrickBox& box) {
  return 1 +
         std::max({box.last.x - box.first.x, box.last.y - box.first.y, box.last.z - box.first.z});
}

/// Boxes of the whole levels, finest first, from the samples of the first.
std::vector<BrickBox> whole_boxes(const SampleLevel& samples) {
  std::vector<BrickBox> boxes{whole_box(samples)};
  while (widest(boxes.back()) > kCoarsestBricks) {
    const BrickBox next = coarser(boxes.back());
    if (widest(next) == widest(boxes.back())) break;
    boxes.push_back(next);
  }
  return boxes;
}

std::vector<Grid> make_grids(const std::vector<SampleLevel>& samples,
                             const std::vector<BrickBox>& whole, int threads) {
  std::vector<Grid> grids;
  for (int l = 0; l < kFirstWhole; ++l) grids.push_back(make_band(samples[l], threads));
  for (const BrickBox& box : whole) grids.push_back(make_whole(box, threads));
  return grids;
}

std::vector<LevelView> views(std::span<const Grid> grids) {
  std::vector<LevelView> made;
  for (const Grid& grid : grids) made.push_back({grid.bricks, &grid.index, grid.values});
  return made;
}

/// Solves all levels, coarse to fine. Each is told to the coarser ones down to kFirstWhole as soon
/// as it is there, and corrected by what they make of it.
class Levels {
 public:
  Levels(std::vector<Grid>& grids, std::vector<SampleLevel>& samples, const SolveOptions& options)
      : grids_(grids),
        samples_(samples),
        options_(options),
        screening_(grids.size()),
        passes_(grids.size()) {}

  LevelReport solve(int level) {
    Grid& grid = grids_[at(level)];
    if (level + 1 < static_cast<int>(grids_.size()))
      prolong(grid, coarser(level), options_.threads);
    const auto weight = static_cast<float>(options_.point_weight);
    Screening& screening =
        screening_[at(level)].emplace(grid, samples_[at(level)], weight,
                                      level == 0 ? Hold::kLoose : Hold::kOwn, options_.threads);
    relax_level(level, grid.constraints);
    if (level == 0) {
      // What a loosely held field misses tells where the ground wants a firmer hold.
      loosen_pull(samples_, fields_at_samples(samples_[0], views(grids_), options_.threads),
                  options_.threads);
      screening.hold_with_pull(grid, samples_[0], weight, options_.threads);
    }
    if (level < kFirstWhole) correct(level);
    const Residual left = residual(grid, screening, options_.threads);
    return {std::ldexp(options_.lattice.step_m, level),
            samples_[at(level)].samples.size(),
            grid.bricks.size(),
            count_active(grid),
            left.zero > 0.0 ? left.left / left.zero : 0.0,
            0};
  }
  int passes(std::size_t level) const { return passes_[level]; }

 private:
  static std::size_t at(int level) { return static_cast<std::size_t>(level); }
  std::vector<LevelView> coarser(int level) const {
    return views(std::span(grids_).subspan(at(level + 1)));
  }
  void relax_level(int level, const std::vector<float>& right_side) {
    const int passes = options_.relaxations * (grids_[at(level)].whole ? kWholeFactor : 1);
    relax(grids_[at(level)], right_side, *screening_[at(level)], passes, options_.threads);
    passes_[at(level)] += passes;
  }
  void correct(int finest) {
    for (int l = finest; l < kFirstWhole; ++l)
      raise(grids_[at(l)], *screening_[at(l)], grids_[at(l + 1)], l == finest, options_.threads);
    finish_raise(grids_[kFirstWhole], *screening_[kFirstWhole], options_.threads);
    relax_level(kFirstWhole, grids_[kFirstWhole].right_side);
    for (int l = kFirstWhole - 1; l >= finest; --l) {
      Grid& grid = grids_[at(l)];
      lower(grid, coarser(l), options_.threads);
      relax_level(l, l == finest ? grid.constraints : grid.right_side);
    }
  }

  std::vector<Grid>& grids_;
  std::vector<SampleLevel>& samples_;
  const SolveOptions& options_;
  std::vector<std::optional<Screening>> screening_;
  std::vector<int> passes_;
};

/// Mean of the field at the finest samples, weighted by area.
double field_at(const SampleLevel& samples, std::span<const Grid> grids, int threads) {
  const std::vector<float> fields = fields_at_samples(samples, views(grids), threads);
  double value = 0.0, area = 0.0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto of_sample = static_cast<double>(samples.samples[i].area);
    value += of_sample * static_cast<double>(fields[i]);
    area += of_sample;
  }
  return area > 0.0 ? value / area : 0.0;
}

Field make_field(Lattice lattice, std::vector<Grid>& grids) {
  std::vector<FieldLevel> levels;
  for (Grid& grid : grids) levels.push_back({std::move(grid.bricks), std::move(grid.values)});
  grids.clear();
  return Field(lattice, std::move(levels));
}

std::string left_out_text(const SolveReport& report) {
  return std::to_string(report.not_finite) + " are not finite, " +
         std::to_string(report.without_normal) + " have no normal or quality 0, " +
         std::to_string(report.outside) + " lie outside the domain";
}

}  // namespace

Solution solve_poisson(const OrientedPoints& points, const Box3d& domain,
                       const SolveOptions& options, Progress& progress) {
  check(options);
  Solution solution;
  SolveReport& report = solution.report;
  Steps step(progress, report);
  const double step_m = options.lattice.step_m;
  const int threads = options.threads;

  std::vector<SampleLevel> samples(1);
  step("gathering points", [&] {
    LeftOut left_out;
    samples[0] = gather_samples(points, domain, step_m, threads, left_out);
    report.not_finite = left_out.not_finite;
    report.without_normal = left_out.without_normal;
    report.outside = left_out.outside;
    report.points =
        points.positions.size() - left_out.not_finite - left_out.without_normal - left_out.outside;
  });
  if (report.points == 0)
    throw InputError("", "no oriented point to reconstruct from: of " +
                             std::to_string(points.positions.size()) + " points " +
                             left_out_text(report));

  std::vector<BrickBox> whole;
  step("estimating density", [&] {
    while (samples.size() <= kFirstWhole)
      samples.push_back(coarser_samples(samples.back(), threads));
    whole = whole_boxes(samples.back());
    while (samples.size() < kFirstWhole + whole.size())
      samples.push_back(coarser_samples(samples.back(), threads));
    estimate_density(samples, options.points_per_cell, threads);
  });
  std::vector<Grid> grids =
      step("choosing nodes", [&] { return make_grids(samples, whole, threads); });
  step("splatting normals", [&] { set_constraints(grids, samples, threads); });
  step("solving", [&] {
    Levels levels(grids, samples, options);
    report.levels.resize(grids.size());
    for (std::size_t l = grids.size(); l-- > 0;) {
      check_cancelled(progress);
      report.levels[l] = levels.solve(static_cast<int>(l));
    }
    for (std::size_t l = 0; l < grids.size(); ++l) report.levels[l].passes = levels.passes(l);
    for (Grid& grid : grids) {
      std::vector<float>().swap(grid.constraints);
      std::vector<float>().swap(grid.right_side);
    }
  });
  step("finding the level of the surface",
       [&] { report.field_at_points = field_at(samples[0], grids, threads); });
  solution.field = make_field(options.lattice, grids);
  return solution;
}

}  // namespace cornice
