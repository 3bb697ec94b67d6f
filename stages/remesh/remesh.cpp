// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/remesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <optional>

#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "stages/remesh/attributes.h"
#include "stages/remesh/measure.h"
#include "stages/remesh/passes.h"
#include "stages/remesh/sizing.h"

namespace cornice::remesh {
namespace {

/// Of the error bound: what decimation may use, as root mean square of plane distances and as
/// distance.
constexpr double kQuadricShare = 0.5;
constexpr float kDecimationShare = 0.6f;
/// What anything may use at the places that are looked at while the mesh changes; the rest is for
/// places between them.
constexpr float kGuardShare = 0.78f;
/// Distances below this share of the bound are not told apart.
constexpr float kEnoughShare = 0.7f;
/// What is farther is repaired; the rest of the bound is for places between those looked at.
constexpr float kRepairShare = 0.87f;
/// Places on other sheets are looked for before one counts as too far.
constexpr float kSearchShare = kRepairShare;
/// What repair may use: its places lie as close as those of the measurement.
constexpr float kMendShare = 0.84f;
/// What may be left where repair stands still.
constexpr float kBearableShare = 0.97f;
/// Rounds of flipping and smoothing in all passes but the last: sizes change after each.
constexpr int kEarlyRounds = 1;
constexpr int kMostRepairs = 24;
/// Rounds that bring nothing before more is allowed, and before no more are made.
constexpr int kIdle = 2, kMostIdle = 6;
/// Rounds of mending shapes; no more where one leaves this share of the thin triangles.
constexpr int kMostShapeRounds = 3;
constexpr double kShapesLeft = 0.9;
/// Beginnings anew with more of the input kept as it is.
constexpr int kMostAttempts = 2;
/// Places on new triangles lie so many spacings of the input apart while the mesh changes, and in
/// the end.
constexpr float kGuardSpacing = 1.2f;
constexpr float kSmall = 1.5f;
constexpr float kDoubt = 0.4f;
constexpr float kFinalSpacing = 0.45f;
/// Of that, where a first repair did not help.
constexpr float kFineShare = 0.4f;
/// Number of triangles of a patch to aim at: what is kept of each stays in the second-level cache,
/// and there are enough patches to share out.
constexpr double kDecimationPatch = 60000.0;
constexpr double kPatch = 6000.0;
/// Shifts of the grid of patches, pass by pass: rims of one pass lie inside patches of the next.
constexpr double kShifts[][2] = {{0.0, 0.0},   {0.5, 0.5}, {0.25, 0.75}, {0.75, 0.25},
                                 {0.125, 0.4}, {0.6, 0.9}, {0.35, 0.1},  {0.9, 0.65}};

/// The input without triangles that name a vertex twice or repeat another; `dropped` counts them.
std::vector<Triangle> sound_triangles(const std::vector<Triangle>& triangles,
                                      std::size_t vertex_count, int threads,
                                      std::vector<std::uint32_t>& twins, std::uint64_t& dropped) {
  std::vector<Triangle> sound = triangles;
  twins = match_half_edges(sound, vertex_count, threads);
  // Only triangles at edges that are no manifold can be repeated ones.
  std::vector<std::uint32_t> suspects;
  for (std::uint32_t t = 0; t < sound.size(); ++t) {
    bool suspect = false;
    for (int k = 0; k < 3; ++k) suspect = suspect || twins[3 * t + k] == kNonManifoldEdge;
    // Two triangles of the same three vertices and opposite sides match edge by edge.
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t twin = twins[3 * t + k];
      suspect = suspect || (twin < kNoTwin && twins[3 * t + (k + 1) % 3] / 3 == twin / 3);
    }
    if (suspect) suspects.push_back(t);
  }
  if (suspects.empty()) return sound;
  const auto key = [&](std::uint32_t t) {
    Triangle k = sound[t];
    std::sort(k.begin(), k.end());
    return k;
  };
  std::sort(suspects.begin(), suspects.end(), [&](std::uint32_t a, std::uint32_t b) {
    return key(a) != key(b) ? key(a) < key(b) : a < b;
  });
  std::vector<std::uint8_t> drop(sound.size(), 0);
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    const Triangle k = key(suspects[i]);
    if (k[0] == k[1] || k[1] == k[2] || (i > 0 && k == key(suspects[i - 1]))) drop[suspects[i]] = 1;
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < sound.size(); ++t) {
    if (drop[t] == 0) sound[kept++] = sound[t];
  }
  dropped = sound.size() - kept;
  sound.resize(kept);
  if (dropped > 0) twins = match_half_edges(sound, vertex_count, threads);
  return sound;
}

/// Hangs every vertex that a triangle names onto one of them.
void hang_vertices(WorkMesh& work) {
  std::vector<std::uint8_t> seen(work.positions.size(), 0);
  std::vector<std::uint32_t> first(1, 0), samples;
  first.reserve(work.triangles.size() + 1);
  samples.reserve(work.samples.size() + work.triangles.size() / 2);
  for (std::size_t t = 0; t < work.triangles.size(); ++t) {
    samples.insert(samples.end(), work.samples.begin() + work.sample_first[t],
                   work.samples.begin() + work.sample_first[t + 1]);
    for (const std::uint32_t v : work.triangles[t]) {
      if (seen[v] == 0) samples.push_back(v);
      seen[v] = 1;
    }
    first.push_back(static_cast<std::uint32_t>(samples.size()));
  }
  work.sample_first = std::move(first);
  work.samples = std::move(samples);
}

class Remeshing {
 public:
  Remeshing(const Mesh& input, const Options& options, Progress& progress)
      : input_(input), options_(options), progress_(progress) {
    sizes_.error_m = static_cast<float>(options.max_error_m);
    sizes_.min_edge_m = static_cast<float>(options.min_edge_m);
    sizes_.max_edge_m = static_cast<float>(options.max_edge_m);
    sizes_.grading = static_cast<float>(options.grading);
    relax_.reach_m = std::max(4.0f * sizes_.error_m, 0.25f);
  }

  Result run() {
    figures_.input_triangles = input_.triangles.size();
    step("prepare", [&] { prepare(); });
    Result result;
    if (!sound_.empty()) {
      std::optional<Reference> indexed;
      step("index",
           [&] { indexed.emplace(input_.positions, sound_, std::move(twins_), options_.threads); });
      const Reference& reference = *indexed;
      for (int attempt = 0;; ++attempt) {
        start_over();
        step("decimate", [&] { decimate_all(reference); });
        step("remesh", [&] { relax_all(reference); });
        std::vector<Offence> left;
        step("repair", [&] { left = repair(reference); });
        if (left.empty()) step("shapes", [&] { left = mend_shapes(reference); });
        if (left.empty() || attempt == kMostAttempts) break;
        ++figures_.attempts;
        freeze(reference, left);
      }
      step("finish", [&] { finish(reference, result); });
    }
    result.mesh.origin = input_.origin;
    result.mesh.crs_text = input_.crs_text;
    result.figures = figures_;
    return result;
  }

 private:
  template <class Work>
  void step(const char* name, const Work& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    figures_.steps.push_back({name, seconds.count()});
  }

  void prepare() {
    sound_ = sound_triangles(input_.triangles, input_.positions.size(), options_.threads, twins_,
                             figures_.dropped_triangles);
    fixed_ = border_vertices(sound_, twins_, input_.positions.size());
    for (const std::uint32_t twin : twins_) figures_.bad_input_edges += twin == kNonManifoldEdge;
    double sum = 0.0;
    const std::size_t stride = sound_.size() / 10000 + 1;
    std::size_t count = 0;
    for (std::size_t t = 0; t < sound_.size(); t += stride, ++count) {
      sum += norm((input_.positions[sound_[t][1]] - input_.positions[sound_[t][0]]).cast<double>());
    }
    spacing_ =
        static_cast<float>(count == 0 ? 1.0 : std::max(sum / static_cast<double>(count), 1e-4));
    relax_.guard = {kGuardShare * sizes_.error_m, kGuardSpacing * spacing_, 0.0f, 0.0f};
  }

  void start_over() {
    work_ = {};
    work_.triangles = sound_;
    work_.positions = input_.positions;
    work_.fixed = fixed_;
    kept_ = 0.0f;
    places_.clear();
    borrowings_.clear();
  }

  PatchGrid grid(int pass, double area) const {
    const auto& shift = kShifts[static_cast<std::size_t>(pass) % std::size(kShifts)];
    return {std::sqrt(std::max(area, 1e-9)), shift[0], shift[1]};
  }

  void decimate_all(const Reference& reference) {
    const double area =
        kDecimationPatch * 0.45 * static_cast<double>(spacing_) * static_cast<double>(spacing_);
    const DecimateLimits limits{static_cast<float>(kQuadricShare * options_.max_error_m),
                                sizes_.max_edge_m,
                                {kDecimationShare * sizes_.error_m, kGuardSpacing * spacing_,
                                 kSmall * spacing_, kDoubt * sizes_.error_m}};
    progress_.begin("decimate", 2 * work_.triangles.size());
    for (int pass = 0; pass < 2; ++pass) {
      decimate_pass(work_, reference, grid(pass, area), limits, options_.threads, progress_);
    }
    progress_.end();
    figures_.decimated_triangles = work_.triangles.size();
    hang_vertices(work_);
    work_.source.resize(work_.positions.size());
    work_.hint.resize(work_.positions.size());
    for (std::uint32_t v = 0; v < work_.source.size(); ++v) {
      work_.source[v] = v;
      work_.hint[v] = reference.triangle_at(v);
    }
    compact(work_);
    start_sizes(work_, sizes_);
    grade_sizes(work_, sizes_);
  }

  double mean_area() const {
    double sum = 0.0;
    std::size_t count = 0;
    const std::size_t stride = work_.triangles.size() / 10000 + 1;
    for (std::size_t t = 0; t < work_.triangles.size(); t += stride, ++count) {
      const Triangle& c = work_.triangles[t];
      const Vec3f p = work_.positions[c[0]];
      sum += 0.5 *
             static_cast<double>(norm(cross(work_.positions[c[1]] - p, work_.positions[c[2]] - p)));
    }
    return count == 0 ? 1.0 : sum / static_cast<double>(count);
  }

  void relax_all(const Reference& reference) {
    progress_.begin("remesh", static_cast<std::uint64_t>(options_.passes));
    for (int pass = 0; pass < options_.passes; ++pass) {
      adapt_sizes(work_, sizes_, 0.6f, pass + 1 < options_.passes ? 1.6f : 1.0f);
      grade_sizes(work_, sizes_);
      RelaxLimits limits = relax_;
      if (pass + 1 < options_.passes) limits.rounds = kEarlyRounds;
      relax_pass(work_, reference, grid(pass, kPatch * mean_area()), limits, options_.threads,
                 no_progress());
      check_cancelled(progress_);
      progress_.advance(1);
    }
    progress_.end();
  }

  /// Measures, and cuts what leaves the bound, while that helps. Returns what is left.
  std::vector<Offence> repair(const Reference& reference) {
    const MeasureLimits limits{kEnoughShare * sizes_.error_m, kSearchShare * sizes_.error_m,
                               kRepairShare * sizes_.error_m, kFinalSpacing * spacing_};
    figures_.sample_spacing_m = static_cast<double>(limits.spacing_m);
    std::size_t before = std::numeric_limits<std::size_t>::max();
    int idle = 0;
    for (int round = 0;; ++round) {
      Distances distances =
          measure_distances(work_, reference, limits, borrowings_, options_.threads);
      kept_ = std::max(kept_, distances.kept_m);
      figures_.input_to_result_m =
          static_cast<double>(std::max(kept_, distances.input_to_result_m));
      figures_.result_to_input_m =
          static_cast<double>(std::max(kept_, distances.result_to_input_m));
      borrowings_ = std::move(distances.borrowings);
      const std::size_t count = distances.offences.size();
      // Where a change has to stand by its neighbours it may take a round to come through.
      idle = count < before ? 0 : idle + 1;
      std::vector<Offence> unbearable = distances.offences;
      std::erase_if(unbearable, [&](const Offence& o) {
        return o.distance_m <= kBearableShare * sizes_.error_m;
      });
      if (round == kMostRepairs || idle == kMostIdle || (idle >= kIdle && unbearable.empty()) ||
          count == 0) {
        // Only what changes is measured from here on.
        kept_ = std::max({kept_, distances.input_to_result_m, distances.result_to_input_m});
        return unbearable;
      }
      before = std::min(count, before);
      ++figures_.repair_rounds;
      for (const Offence& o : distances.offences) {
        if (o.must_reach) places_.push_back(o.through);
      }
      mend_pass(work_, reference, mend_grid(round), mend_limits(round, idle), distances.offences,
                places_, options_.threads);
      check_cancelled(progress_);
    }
  }

  /// Where rounds bring nothing any more, more is allowed.
  RelaxLimits mend_limits(int round, int idle) const {
    const bool stands_still = idle >= kIdle;
    RelaxLimits limits = relax_;
    limits.guard = {(stands_still ? kBearableShare : kMendShare) * sizes_.error_m,
                    (round < 2 ? 1.0f : kFineShare) * kFinalSpacing * spacing_, 0.0f, 0.0f, true};
    if (stands_still) limits.least_facing = -1.0f;
    limits.insists = stands_still;
    return limits;
  }

  std::size_t thin_triangles() const {
    return static_cast<std::size_t>(
        std::count_if(work_.triangles.begin(), work_.triangles.end(), [&](const Triangle& c) {
          return is_thin(work_.positions[c[0]], work_.positions[c[1]], work_.positions[c[2]]);
        }));
  }

  /// Mends thin triangles while that helps. Returns what leaves the bound after it.
  std::vector<Offence> mend_shapes(const Reference& reference) {
    std::vector<Offence> left;
    std::size_t thin = thin_triangles();
    for (int round = 0; round < kMostShapeRounds && thin > 0 && left.empty(); ++round) {
      shape_pass(work_, reference, mend_grid(round), mend_limits(kMostRepairs, 0), places_,
                 options_.threads);
      left = repair(reference);
      const std::size_t before = thin;
      thin = thin_triangles();
      if (static_cast<double>(thin) > kShapesLeft * static_cast<double>(before)) break;
    }
    return left;
  }

  /// Small patches: few of them have something to mend.
  PatchGrid mend_grid(int round) const {
    PatchGrid local = grid(round, kPatch * mean_area());
    local.side_m = std::min(local.side_m, 40.0 * static_cast<double>(spacing_));
    return local;
  }

  /// Marks the input round offences: vertices that hang on triangles next to theirs.
  void freeze(const Reference& reference, const std::vector<Offence>& offences) {
    std::vector<std::uint8_t> near(work_.positions.size(), 0);
    for (const Offence& o : offences) {
      for (const std::uint32_t v : work_.triangles[o.triangle]) near[v] = 1;
      for (const std::uint32_t v : sound_[o.input_triangle]) fixed_[v] |= kFrozen;
    }
    for (std::size_t t = 0; t < work_.triangles.size(); ++t) {
      const Triangle& c = work_.triangles[t];
      if ((near[c[0]] | near[c[1]] | near[c[2]]) == 0) continue;
      for (std::uint32_t s = work_.sample_first[t]; s < work_.sample_first[t + 1]; ++s) {
        fixed_[work_.samples[s]] |= kFrozen;
      }
    }
    // A ring more: triangles stay as they are where all three corners do.
    const std::vector<std::uint8_t> inner = fixed_;
    for (const Triangle& c : reference.triangles()) {
      if (((inner[c[0]] | inner[c[1]] | inner[c[2]]) & kFrozen) == 0) continue;
      for (const std::uint32_t v : c) fixed_[v] |= kFrozen;
    }
  }

  void finish(const Reference& reference, Result& result) {
    result.mesh.positions = work_.positions;
    result.mesh.triangles = work_.triangles;
    transfer_attributes(input_, reference, work_, result.mesh, options_.threads);
    std::vector<std::uint8_t> inner(work_.triangles.size(), 1);
    for (std::size_t t = 0; t < inner.size(); ++t) {
      for (const std::uint32_t v : work_.triangles[t]) {
        if (work_.fixed[v] != 0) inner[t] = 0;
      }
    }
    for (const std::uint8_t f : work_.fixed) figures_.fixed_vertices += f != 0;
    figures_.quality = measure_quality(work_.positions, work_.triangles, options_.threads);
    figures_.inner_quality =
        measure_quality(work_.positions, work_.triangles, options_.threads, inner);
  }

  const Mesh& input_;
  const Options& options_;
  Progress& progress_;
  std::vector<Triangle> sound_;
  std::vector<std::uint32_t> twins_;  ///< of sound_, until the reference has them
  std::vector<std::uint8_t> fixed_;   ///< vertices of the input
  WorkMesh work_;
  float kept_ = 0.0f;                  ///< largest distance that needed no repair
  std::vector<Vec3f> places_;          ///< of the input, that repair has gone through
  std::vector<Borrowing> borrowings_;  ///< see Distances
  SizeLimits sizes_;
  RelaxLimits relax_;
  Figures figures_;
  float spacing_ = 1.0f;  ///< of the input's vertices, about
};

}  // namespace

Result remesh(const Mesh& mesh, const Options& options, Progress& progress) {
  return Remeshing(mesh, options, progress).run();
}

}  // namespace cornice::remesh
