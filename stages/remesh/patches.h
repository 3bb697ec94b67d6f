// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh cut into square columns, each of which one thread works on alone.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/progress.h"
#include "core/mesh/topology.h"

namespace cornice::remesh {

/// A mesh under work. Every vertex has a wanted edge length and the input triangle it was last seen
/// near.
struct WorkMesh {
  std::vector<Vec3f> positions;
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> fixed;  ///< not 0: never moved, never removed; or kFrozen, too
  std::vector<float> size;          ///< wanted length of edges, metres; empty at first
  std::vector<std::uint32_t>
      source;                       ///< input vertex that is this one, or kNoSource; empty at first
  std::vector<std::uint32_t> hint;  ///< input triangle; empty at first
  /// Input vertices that hang on each triangle t (see guard.h): samples[sample_first[t]] up to
  /// sample_first[t + 1]. Both empty: none on any.
  std::vector<std::uint32_t> sample_first, samples;
  std::vector<float> error;           ///< largest distance of these, per triangle; empty at first
  std::vector<std::uint8_t> changed;  ///< by the last pass, per triangle; empty at first
};
inline constexpr std::uint32_t kNoSource = 0xffffffffu;

/// Triangles by column of side_m, the grid of columns moved by `shift` of a side in x and y.
struct Patches {
  std::vector<std::uint32_t> first;  ///< #patches + 1
  std::vector<std::uint32_t> triangles;
  std::size_t size() const { return first.size() - 1; }
};
Patches cut_patches(const WorkMesh& mesh, double side_m, double shift_x, double shift_y);

/// One patch with vertices of its own: those numbered below `outer` must stay, because triangles of
/// other patches may use them.
struct Patch {
  std::vector<std::uint32_t> vertices;  ///< of the whole mesh
  std::vector<Triangle> triangles;      ///< of local vertices
  std::vector<std::uint8_t> fixed;      ///< per local vertex: fixed, or on the rim of the patch
};

/// Calls work(patch index, patch) for every patch whose byte in `chosen` (empty: all) is not 0, in
/// parallel, each patch exactly once.
void for_each_patch(const WorkMesh& mesh, const Patches& patches,
                    const std::vector<std::uint8_t>& chosen, int threads, Progress& progress,
                    const std::function<void(std::size_t index, Patch& patch)>& work);

}  // namespace cornice::remesh
