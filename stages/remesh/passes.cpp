// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/passes.h"

#include <utility>

namespace cornice::remesh {
namespace {

std::vector<Vec3f> positions_of(const WorkMesh& mesh, const Patch& patch) {
  std::vector<Vec3f> positions;
  positions.reserve(patch.vertices.size());
  for (const std::uint32_t v : patch.vertices) positions.push_back(mesh.positions[v]);
  return positions;
}

std::vector<std::uint8_t> patches_of_vertices(const WorkMesh& mesh, const Patches& patches,
                                              const std::vector<std::uint8_t>& vertices) {
  std::vector<std::uint8_t> chosen;
  if (vertices.empty()) return chosen;
  chosen.assign(patches.size(), 0);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (std::uint32_t i = patches.first[p]; i < patches.first[p + 1] && chosen[p] == 0; ++i) {
      for (const std::uint32_t v : mesh.triangles[patches.triangles[i]]) {
        if (vertices[v] != 0) chosen[p] = 1;
      }
    }
  }
  return chosen;
}

/// What became of one patch. Local vertices below `old.size()` are those of the whole mesh.
struct Relaxed {
  std::vector<std::uint32_t> old;
  std::vector<std::uint8_t> rim;  ///< of the old ones
  RelaxPatch patch{PatchMesh({}, {}, {}), {}, {}};
};

Relaxed relax_patch(const WorkMesh& mesh, Patch& patch, const TriangleTree& input,
                    const RelaxLimits& limits) {
  RelaxPatch work{
      PatchMesh(positions_of(mesh, patch), std::move(patch.triangles), patch.fixed), {}, {}};
  for (const std::uint32_t v : patch.vertices) {
    work.size.push_back(mesh.size[v]);
    work.hint.push_back(mesh.hint[v]);
  }
  relax(work, input, limits);
  return {std::move(patch.vertices), std::move(patch.fixed), std::move(work)};
}

/// Puts the vertices of a relaxed patch into the mesh; returns their numbers there.
std::vector<std::uint32_t> place_vertices(WorkMesh& mesh, const Relaxed& done) {
  std::vector<std::uint32_t> numbers = done.old;
  const PatchMesh& local = done.patch.mesh;
  for (std::uint32_t v = 0; v < local.vertex_count(); ++v) {
    if (v < done.old.size()) {
      if (done.rim[v] != 0 || !local.vertex_alive(v)) continue;
      const std::uint32_t to = done.old[v];
      if (mesh.positions[to] != local.position(v)) mesh.source[to] = kNoSource;
      mesh.positions[to] = local.position(v);
      mesh.size[to] = done.patch.size[v];
      mesh.hint[to] = done.patch.hint[v];
      continue;
    }
    numbers.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
    mesh.positions.push_back(local.position(v));
    mesh.fixed.push_back(0);
    mesh.size.push_back(done.patch.size[v]);
    mesh.source.push_back(kNoSource);
    mesh.hint.push_back(done.patch.hint[v]);
  }
  return numbers;
}

}  // namespace

void decimate_pass(WorkMesh& mesh, const PatchGrid& grid, const DecimateLimits& limits, int threads,
                   Progress& progress) {
  const Patches patches = cut_patches(mesh, grid.side_m, grid.shift_x, grid.shift_y);
  std::vector<std::vector<Triangle>> results(patches.size());
  for_each_patch(mesh, patches, {}, threads, progress, [&](std::size_t index, Patch& patch) {
    std::vector<Triangle> left =
        decimate(positions_of(mesh, patch), patch.fixed, std::move(patch.triangles), limits);
    for (Triangle& t : left) t = {patch.vertices[t[0]], patch.vertices[t[1]], patch.vertices[t[2]]};
    left.shrink_to_fit();
    results[index] = std::move(left);
  });
  mesh.triangles.clear();
  for (const auto& part : results) {
    mesh.triangles.insert(mesh.triangles.end(), part.begin(), part.end());
  }
}

void relax_pass(WorkMesh& mesh, const TriangleTree& input, const PatchGrid& grid,
                const RelaxLimits& limits, const std::vector<std::uint8_t>& chosen, int threads,
                Progress& progress) {
  const Patches patches = cut_patches(mesh, grid.side_m, grid.shift_x, grid.shift_y);
  const std::vector<std::uint8_t> wanted = patches_of_vertices(mesh, patches, chosen);
  std::vector<Relaxed> results(patches.size());
  for_each_patch(mesh, patches, wanted, threads, progress, [&](std::size_t index, Patch& patch) {
    results[index] = relax_patch(mesh, patch, input, limits);
  });
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size() + mesh.triangles.size() / 4);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (results[p].old.empty()) {
      for (std::uint32_t i = patches.first[p]; i < patches.first[p + 1]; ++i) {
        triangles.push_back(mesh.triangles[patches.triangles[i]]);
      }
      continue;
    }
    const std::vector<std::uint32_t> to = place_vertices(mesh, results[p]);
    const PatchMesh& local = results[p].patch.mesh;
    for (std::uint32_t t = 0; t < local.triangle_count(); ++t) {
      if (!local.triangle_alive(t)) continue;
      triangles.push_back(
          {to[local.start(3 * t)], to[local.start(3 * t + 1)], to[local.start(3 * t + 2)]});
    }
    results[p] = {};
  }
  mesh.triangles = std::move(triangles);
  compact(mesh);
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
