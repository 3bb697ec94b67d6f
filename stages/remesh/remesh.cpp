// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/remesh.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/mesh/surface_distance.h"
#include "core/mesh/topology.h"
#include "stages/remesh/attributes.h"
#include "stages/remesh/passes.h"
#include "stages/remesh/sizing.h"

namespace cornice::remesh {
namespace {

/// Of the error bound: what decimation may use, as root mean square of plane distances.
constexpr double kDecimationShare = 0.3;
/// Errors below this share of the bound are not told apart.
constexpr float kEnoughShare = 0.5f;
/// Sizes are learnt from every so manieth vertex of the input; the bound is checked at all.
constexpr std::size_t kLearningStride = 6;
/// Samples of the result lie so many spacings of the input apart.
constexpr float kBackSpacing = 1.0f;
/// Errors above this share are repaired, so that samples between ours stay within the bound, too.
constexpr float kRepairShare = 0.88f;
constexpr int kMostRepairs = 12;
/// Largest number of triangles of a patch to aim at: half-edges and boxes stay in the second-level
/// cache.
constexpr double kPatchTriangles = 60000.0;
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

/// Any triangle that names each vertex.
void fill_hints(WorkMesh& work, const Mesh& input) {
  std::vector<std::uint32_t> some(input.positions.size(), 0);
  for (std::uint32_t t = 0; t < input.triangles.size(); ++t) {
    for (const std::uint32_t v : input.triangles[t]) some[v] = t;
  }
  work.hint.resize(work.source.size());
  for (std::size_t v = 0; v < work.source.size(); ++v) work.hint[v] = some[work.source[v]];
}

class Remeshing {
 public:
  Remeshing(const Mesh& input, const Options& options, Progress& progress)
      : input_(input), options_(options), progress_(progress) {
    sizes_.error_m = static_cast<float>(options.max_error_m);
    sizes_.min_edge_m = static_cast<float>(options.min_edge_m);
    sizes_.max_edge_m = static_cast<float>(options.max_edge_m);
    sizes_.grading = static_cast<float>(options.grading);
    relax_.error_m = sizes_.error_m;
    relax_.reach_m = std::max(4.0f * sizes_.error_m, 0.25f);
  }

  Result run() {
    figures_.input_triangles = input_.triangles.size();
    prepare();
    Result result;
    if (!work_.triangles.empty()) {
      const TriangleTree tree(input_.positions, input_.triangles, options_.threads);
      decimate_all();
      const std::vector<Vec3f> samples = sample_surface(
          input_.positions, input_.triangles, std::numeric_limits<float>::infinity(), tree.order());
      relax_all(tree, samples);
      repair(tree, samples);
      finish(tree, result);
    }
    result.mesh.origin = input_.origin;
    result.mesh.crs_text = input_.crs_text;
    result.figures = figures_;
    return result;
  }

 private:
  void prepare() {
    std::vector<std::uint32_t> twins;
    work_.triangles = sound_triangles(input_.triangles, input_.positions.size(), options_.threads,
                                      twins, figures_.dropped_triangles);
    std::vector<std::uint8_t> bad;
    work_.fixed = border_vertices(work_.triangles, twins, input_.positions.size(), &bad);
    for (const std::uint32_t twin : twins) figures_.bad_input_edges += twin == kNonManifoldEdge;
    work_.positions = input_.positions;
    double sum = 0.0;
    const std::size_t stride = work_.triangles.size() / 10000 + 1;
    std::size_t count = 0;
    for (std::size_t t = 0; t < work_.triangles.size(); t += stride, ++count) {
      const Triangle& c = work_.triangles[t];
      sum += norm((work_.positions[c[1]] - work_.positions[c[0]]).cast<double>());
    }
    spacing_ =
        static_cast<float>(count == 0 ? 1.0 : std::max(sum / static_cast<double>(count), 1e-4));
  }

  PatchGrid grid(int pass, double triangle_area) const {
    const auto& shift = kShifts[static_cast<std::size_t>(pass) % std::size(kShifts)];
    return {std::sqrt(kPatchTriangles * std::max(triangle_area, 1e-9)), shift[0], shift[1]};
  }

  void decimate_all() {
    const double area = 0.45 * static_cast<double>(spacing_) * static_cast<double>(spacing_);
    const DecimateLimits limits{static_cast<float>(kDecimationShare * options_.max_error_m),
                                sizes_.max_edge_m};
    progress_.begin("decimate", 2 * work_.triangles.size());
    for (int pass = 0; pass < 2; ++pass) {
      decimate_pass(work_, grid(pass, area), limits, options_.threads, progress_);
    }
    progress_.end();
    figures_.decimated_triangles = work_.triangles.size();
    work_.source.resize(work_.positions.size());
    for (std::uint32_t v = 0; v < work_.source.size(); ++v) work_.source[v] = v;
    compact(work_);
    fill_hints(work_, input_);
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

  void relax_all(const TriangleTree& tree, const std::vector<Vec3f>& samples) {
    std::vector<Vec3f> some;
    for (std::size_t i = 0; i < samples.size(); i += kLearningStride) some.push_back(samples[i]);
    progress_.begin("remesh", static_cast<std::uint64_t>(options_.passes));
    for (int pass = 0; pass < options_.passes; ++pass) {
      const TriangleTree surface(work_.positions, work_.triangles, options_.threads);
      const std::vector<float> errors =
          triangle_errors(some, surface, kEnoughShare * sizes_.error_m, options_.threads);
      adapt_sizes(work_, errors, sizes_, 0.6f, pass + 1 < options_.passes ? 1.3f : 1.0f);
      grade_sizes(work_, sizes_);
      relax_pass(work_, tree, grid(pass, 0.4 * mean_area()), relax_, {}, options_.threads,
                 no_progress());
      check_cancelled(progress_);
      progress_.advance(1);
    }
    progress_.end();
  }

  /// Errors of both directions, by triangle of the present surface.
  std::vector<float> two_sided_errors(const TriangleTree& tree, const std::vector<Vec3f>& samples) {
    const TriangleTree surface(work_.positions, work_.triangles, options_.threads);
    const float enough = kRepairShare * sizes_.error_m;
    std::vector<float> errors = triangle_errors(samples, surface, enough, options_.threads);
    figures_.input_to_result_m = largest(errors);
    std::vector<float> back(errors.size(), 0.0f);
    // Back: the samples of one triangle are its own.
    parallel_for(surface.order().size(), 2048, options_.threads,
                 [&](std::size_t begin, std::size_t end) {
                   NearestQuery query;
                   query.enough_sq = enough * enough;
                   std::vector<Vec3f> own;
                   for (std::size_t i = begin; i < end; ++i) {
                     const std::uint32_t t = surface.order()[i];
                     const Triangle& c = work_.triangles[t];
                     own.assign(1, work_.positions[c[0]]);
                     sample_triangle(work_.positions[c[0]], work_.positions[c[1]],
                                     work_.positions[c[2]], kBackSpacing * spacing_, own);
                     for (const Vec3f p : own) {
                       const NearestPoint found = tree.nearest(p, query);
                       query.guess = found.triangle;
                       back[t] = std::max(back[t], std::sqrt(found.distance_sq));
                     }
                   }
                 });
    figures_.result_to_input_m = largest(back);
    for (std::size_t t = 0; t < back.size(); ++t) errors[t] = std::max(errors[t], back[t]);
    return errors;
  }

  static double largest(const std::vector<float>& values) {
    return values.empty() ? 0.0
                          : static_cast<double>(*std::max_element(values.begin(), values.end()));
  }

  void repair(const TriangleTree& tree, const std::vector<Vec3f>& samples) {
    for (int round = 0; round <= kMostRepairs; ++round) {
      const std::vector<float> errors = two_sided_errors(tree, samples);
      std::vector<std::uint8_t> chosen(work_.positions.size(), 0);
      std::size_t bad = 0;
      for (std::size_t t = 0; t < errors.size(); ++t) {
        if (errors[t] <= kRepairShare * sizes_.error_m) continue;
        ++bad;
        for (const std::uint32_t v : work_.triangles[t]) chosen[v] = 1;
      }
      if (bad == 0 || round == kMostRepairs) return;
      ++figures_.repair_rounds;
      for (std::size_t v = 0; v < chosen.size(); ++v) {
        if (chosen[v] != 0 && work_.fixed[v] == 0) work_.size[v] *= 0.65f;
      }
      SizeLimits limits = sizes_;
      limits.min_edge_m = std::min(sizes_.min_edge_m, 0.25f * spacing_);
      grade_sizes(work_, limits);
      PatchGrid local = grid(round + 3, 0.4 * mean_area());
      local.side_m = std::min(local.side_m, std::max(24.0 * static_cast<double>(spacing_),
                                                     12.0 * std::sqrt(mean_area())));
      relax_pass(work_, tree, local, relax_, chosen, options_.threads, no_progress());
      check_cancelled(progress_);
    }
  }

  void finish(const TriangleTree& tree, Result& result) {
    figures_.sample_spacing_m = static_cast<double>(kBackSpacing * spacing_);
    result.mesh.positions = work_.positions;
    result.mesh.triangles = work_.triangles;
    transfer_attributes(input_, tree, work_, result.mesh, options_.threads);
    std::vector<std::uint8_t> inner(work_.triangles.size(), 1);
    for (std::size_t t = 0; t < inner.size(); ++t) {
      for (const std::uint32_t v : work_.triangles[t]) {
        if (work_.fixed[v] != 0) inner[t] = 0;
      }
    }
    for (const std::uint8_t f : work_.fixed) figures_.fixed_vertices += f;
    figures_.quality = measure_quality(work_.positions, work_.triangles, options_.threads);
    figures_.inner_quality =
        measure_quality(work_.positions, work_.triangles, options_.threads, inner);
  }

  const Mesh& input_;
  const Options& options_;
  Progress& progress_;
  WorkMesh work_;
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
