// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/passes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace cornice::remesh {
namespace {

std::vector<Vec3f> positions_of(const WorkMesh& mesh, const Patch& patch) {
  std::vector<Vec3f> positions;
  positions.reserve(patch.vertices.size());
  for (const std::uint32_t v : patch.vertices) positions.push_back(mesh.positions[v]);
  return positions;
}

/// Hangs the samples of a patch's triangles onto its local ones.
void load_samples(const WorkMesh& mesh, const Patches& patches, std::size_t index,
                  const Reference& input, Guard& guard) {
  const std::uint32_t begin = patches.first[index], end = patches.first[index + 1];
  guard.resize(end - begin);
  if (mesh.sample_first.empty()) return;
  for (std::uint32_t i = begin; i < end; ++i) {
    const std::uint32_t t = patches.triangles[i];
    const Triangle& c = mesh.triangles[t];
    for (std::uint32_t s = mesh.sample_first[t]; s < mesh.sample_first[t + 1]; ++s) {
      const Vec3f p = input.positions()[mesh.samples[s]];
      const float distance_sq =
          nearest_on_triangle(p, mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]])
              .distance_sq;
      guard.add(i - begin, mesh.samples[s], distance_sq);
    }
  }
}

/// Triangles with what they carry, one after the other.
struct Carriers {
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> counts;  ///< of samples, per triangle
  std::vector<std::uint32_t> samples;
  std::vector<float> error;
  std::vector<std::uint8_t> changed;

  void add(const Triangle& triangle, const Guard& guard, std::uint32_t number,
           std::uint8_t is_changed) {
    triangles.push_back(triangle);
    changed.push_back(is_changed);
    const std::size_t before = samples.size();
    float most_sq = 0.0f;
    guard.each(number, [&](std::uint32_t id, float distance_sq) {
      samples.push_back(id);
      most_sq = std::max(most_sq, distance_sq);
    });
    counts.push_back(static_cast<std::uint32_t>(samples.size() - before));
    error.push_back(std::sqrt(most_sq));
  }
};

/// The triangles of a patch as they are.
Carriers carriers_of(const WorkMesh& mesh, const Patches& patches, std::size_t index) {
  Carriers same;
  for (std::uint32_t i = patches.first[index]; i < patches.first[index + 1]; ++i) {
    const std::uint32_t t = patches.triangles[i];
    same.triangles.push_back(mesh.triangles[t]);
    same.changed.push_back(0);
    same.error.push_back(mesh.error[t]);
    const auto begin = mesh.samples.begin() + mesh.sample_first[t];
    const auto end = mesh.samples.begin() + mesh.sample_first[t + 1];
    same.counts.push_back(static_cast<std::uint32_t>(end - begin));
    same.samples.insert(same.samples.end(), begin, end);
  }
  return same;
}

/// Puts the triangles of all patches into the mesh, in the order of the patches; takes them.
void gather(std::vector<Carriers>& parts, WorkMesh& mesh) {
  std::size_t triangles = 0, samples = 0;
  for (const Carriers& part : parts) {
    triangles += part.triangles.size(), samples += part.samples.size();
  }
  mesh.triangles.clear();
  mesh.error.clear();
  mesh.changed.clear();
  mesh.samples.clear();
  mesh.sample_first.assign(1, 0);
  mesh.triangles.reserve(triangles);
  mesh.error.reserve(triangles);
  mesh.changed.reserve(triangles);
  mesh.sample_first.reserve(triangles + 1);
  mesh.samples.reserve(samples);
  for (Carriers& part : parts) {
    mesh.triangles.insert(mesh.triangles.end(), part.triangles.begin(), part.triangles.end());
    mesh.error.insert(mesh.error.end(), part.error.begin(), part.error.end());
    mesh.changed.insert(mesh.changed.end(), part.changed.begin(), part.changed.end());
    mesh.samples.insert(mesh.samples.end(), part.samples.begin(), part.samples.end());
    for (const std::uint32_t count : part.counts) {
      mesh.sample_first.push_back(mesh.sample_first.back() + count);
    }
    part = {};
  }
}

/// What became of one patch. Local vertices below `old.size()` are those of the whole mesh.
struct Relaxed {
  std::vector<std::uint32_t> old;
  std::vector<std::uint8_t> rim;  ///< of the old ones
  std::vector<Vec3f> positions;   ///< of all local vertices
  std::vector<std::uint8_t> alive;
  std::vector<float> size;
  std::vector<std::uint32_t> hint;
};

using PatchWork = std::function<void(RelaxPatch& work, std::size_t index)>;

Relaxed work_on_patch(const WorkMesh& mesh, const Patches& patches, std::size_t index, Patch& patch,
                      const Reference& input, const GuardLimits& limits, const PatchWork& change,
                      Carriers& carriers) {
  RelaxPatch work{PatchMesh(positions_of(mesh, patch), std::move(patch.triangles), patch.fixed),
                  {},
                  {},
                  Guard(input, limits),
                  {}};
  for (const std::uint32_t v : patch.vertices) {
    work.size.push_back(mesh.size[v]);
    work.hint.push_back(mesh.hint[v]);
  }
  load_samples(mesh, patches, index, input, work.guard);
  change(work, index);
  Relaxed done{std::move(patch.vertices), std::move(patch.fixed), {}, {}, {}, {}};
  const PatchMesh& local = work.mesh;
  for (std::uint32_t v = 0; v < local.vertex_count(); ++v) {
    done.positions.push_back(local.position(v));
    done.alive.push_back(local.vertex_alive(v));
  }
  for (std::uint32_t t = 0; t < local.triangle_count(); ++t) {
    if (!local.triangle_alive(t)) continue;
    carriers.add({local.start(3 * t), local.start(3 * t + 1), local.start(3 * t + 2)}, work.guard,
                 t, work.changed.empty() ? 1 : work.changed[t]);
  }
  done.size = std::move(work.size);
  done.hint = std::move(work.hint);
  return done;
}

/// Puts the vertices of a relaxed patch into the mesh; returns their numbers there.
std::vector<std::uint32_t> place_vertices(WorkMesh& mesh, const Relaxed& done) {
  std::vector<std::uint32_t> numbers = done.old;
  for (std::uint32_t v = 0; v < done.positions.size(); ++v) {
    if (v < done.old.size()) {
      if (done.rim[v] != 0 || done.alive[v] == 0) continue;
      const std::uint32_t to = done.old[v];
      if (mesh.positions[to] != done.positions[v]) mesh.source[to] = kNoSource;
      mesh.positions[to] = done.positions[v];
      mesh.size[to] = done.size[v];
      mesh.hint[to] = done.hint[v];
      continue;
    }
    numbers.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
    mesh.positions.push_back(done.positions[v]);
    mesh.fixed.push_back(0);
    mesh.size.push_back(done.size[v]);
    mesh.source.push_back(kNoSource);
    mesh.hint.push_back(done.hint[v]);
  }
  return numbers;
}

}  // namespace

void decimate_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
                   const DecimateLimits& limits, int threads, Progress& progress) {
  const Patches patches = cut_patches(mesh, grid.side_m, grid.shift_x, grid.shift_y);
  std::vector<Carriers> results(patches.size());
  for_each_patch(mesh, patches, {}, threads, progress, [&](std::size_t index, Patch& patch) {
    Guard guard(input, limits.guard);
    load_samples(mesh, patches, index, input, guard);
    const std::vector<Triangle> left =
        decimate(positions_of(mesh, patch), patch, input, limits, guard);
    for (std::uint32_t t = 0; t < left.size(); ++t) {
      const Triangle& c = left[t];
      results[index].add({patch.vertices[c[0]], patch.vertices[c[1]], patch.vertices[c[2]]}, guard,
                         t, 1);
    }
  });
  gather(results, mesh);
}

namespace {

/// Lets `change` work on every chosen patch (empty: all) and puts what comes of it into the mesh.
void change_patches(WorkMesh& mesh, const Reference& input, const Patches& patches,
                    const std::vector<std::uint8_t>& chosen, const GuardLimits& limits, int threads,
                    Progress& progress, const PatchWork& change) {
  std::vector<Relaxed> results(patches.size());
  std::vector<Carriers> carriers(patches.size());
  for_each_patch(mesh, patches, chosen, threads, progress, [&](std::size_t index, Patch& patch) {
    results[index] =
        work_on_patch(mesh, patches, index, patch, input, limits, change, carriers[index]);
  });
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (results[p].old.empty()) {
      carriers[p] = carriers_of(mesh, patches, p);
      continue;
    }
    const std::vector<std::uint32_t> to = place_vertices(mesh, results[p]);
    for (Triangle& t : carriers[p].triangles) t = {to[t[0]], to[t[1]], to[t[2]]};
    results[p] = {};
  }
  gather(carriers, mesh);
  compact(mesh);
}

}  // namespace

void relax_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
                const RelaxLimits& limits, int threads, Progress& progress) {
  const Patches patches = cut_patches(mesh, grid.side_m, grid.shift_x, grid.shift_y);
  change_patches(mesh, input, patches, {}, limits.guard, threads, progress,
                 [&](RelaxPatch& work, std::size_t) { relax(work, input, limits); });
}

namespace {

/// Those within `reach` of the box round the vertices.
std::vector<Vec3f> places_near(const PatchMesh& mesh, const std::vector<Vec3f>& places,
                               float reach) {
  const float infinity = std::numeric_limits<float>::infinity();
  Vec3f low{infinity, infinity, infinity}, high = low * -1.0f;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3f p = mesh.position(v);
    low = {std::min(low.x, p.x - reach), std::min(low.y, p.y - reach),
           std::min(low.z, p.z - reach)};
    high = {std::max(high.x, p.x + reach), std::max(high.y, p.y + reach),
            std::max(high.z, p.z + reach)};
  }
  std::vector<Vec3f> near;
  for (const Vec3f p : places) {
    if (p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y &&
        p.z <= high.z) {
      near.push_back(p);
    }
  }
  return near;
}

}  // namespace

void mend_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
               const RelaxLimits& limits, const std::vector<Offence>& offences,
               const std::vector<Vec3f>& places, int threads) {
  const Patches patches = cut_patches(mesh, grid.side_m, grid.shift_x, grid.shift_y);
  std::vector<std::vector<Offence>> of_patch(patches.size());
  std::vector<std::uint8_t> chosen(patches.size(), 0);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (std::uint32_t i = patches.first[p]; i < patches.first[p + 1]; ++i) {
      const auto found = std::lower_bound(
          offences.begin(), offences.end(), patches.triangles[i],
          [](const Offence& offence, std::uint32_t t) { return offence.triangle < t; });
      if (found == offences.end() || found->triangle != patches.triangles[i]) continue;
      of_patch[p].push_back(*found);
      of_patch[p].back().triangle = i - patches.first[p];
      chosen[p] = 1;
    }
  }
  change_patches(mesh, input, patches, chosen, limits.guard, threads, no_progress(),
                 [&](RelaxPatch& work, std::size_t index) {
                   mend(work, input, limits, of_patch[index],
                        places_near(work.mesh, places, limits.guard.error_m));
                 });
}

void shape_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
                const RelaxLimits& limits, const std::vector<Vec3f>& places, int threads) {
  const Patches patches = cut_patches(mesh, grid.side_m, grid.shift_x, grid.shift_y);
  std::vector<std::uint8_t> chosen(patches.size(), 0);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (std::uint32_t i = patches.first[p]; i < patches.first[p + 1] && chosen[p] == 0; ++i) {
      const Triangle& c = mesh.triangles[patches.triangles[i]];
      chosen[p] = is_thin(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]);
    }
  }
  change_patches(mesh, input, patches, chosen, limits.guard, threads, no_progress(),
                 [&](RelaxPatch& work, std::size_t) {
                   mend_shapes(work, input, limits,
                               places_near(work.mesh, places, limits.guard.error_m));
                 });
}

void compact(WorkMesh& mesh) {
  std::vector<std::uint32_t> to(mesh.positions.size(), kNoSource);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) to[v] = 0;
  }
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < to.size(); ++v) {
    if (to[v] == kNoSource) continue;
    to[v] = count;
    mesh.positions[count] = mesh.positions[v];
    mesh.fixed[count] = mesh.fixed[v];
    if (!mesh.size.empty()) mesh.size[count] = mesh.size[v];
    if (!mesh.source.empty()) mesh.source[count] = mesh.source[v];
    if (!mesh.hint.empty()) mesh.hint[count] = mesh.hint[v];
    ++count;
  }
  mesh.positions.resize(count);
  mesh.fixed.resize(count);
  if (!mesh.size.empty()) mesh.size.resize(count);
  if (!mesh.source.empty()) mesh.source.resize(count);
  if (!mesh.hint.empty()) mesh.hint.resize(count);
  for (Triangle& t : mesh.triangles) t = {to[t[0]], to[t[1]], to[t[2]]};
}

}  // namespace cornice::remesh
