// SPDX-License-Identifier: GPL-3.0-or-later
// Half-edge collapse by quadric error on one block of cells.
// Garland & Heckbert 1997, "Surface simplification using quadric error metrics"; Lindstrom & Turk
// 1998, "Fast and memory efficient polygonal simplification" (no memory between levels); Li 2024,
// "Multi-scale simplification and visualization of large 3D models", 3.2.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/topology.h"

namespace cornice::hlod {

/// Index of a vertex or triangle that is none.
inline constexpr std::uint32_t kNone = 0xffffffffu;

/// The triangles of one block. Units are free but the same everywhere; whole numbers below 2^22
/// are exact. The surface may have any defect but a triangle that names a vertex twice.
struct SimplifyMesh {
  std::vector<Vec3f> positions;
  /// One byte per vertex: 1 where triangles outside of the block share it. Such a vertex stays.
  std::vector<std::uint8_t> locked;
  std::vector<Triangle> triangles;
  /// Empty, or per vertex further coordinates (colour, texture) whose change costs like a distance.
  std::vector<std::array<float, 3>> further;
};

struct SimplifyOptions {
  /// Stops at so many triangles, or one more collapse below.
  std::size_t target_triangles = 0;
  /// Largest distance (max norm) between a vertex and the one it becomes.
  float reach = std::numeric_limits<float>::infinity();
  /// Distances to what a vertex becomes count in x and y alone, and no triangle that looks up may
  /// come to look down: for height fields, which then stay height fields.
  bool in_plan = false;
  /// No collapse moves the surface by more (root mean square over what the vertex stands for).
  float max_error = std::numeric_limits<float>::infinity();
};

/// Which triangles have a vertex; changes as they collapse.
class VertexFans {
 public:
  void assign(std::size_t vertex_count, const std::vector<Triangle>& triangles);
  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return {pool_.data() + fans_[vertex].first, fans_[vertex].count};
  }
  void remove(std::uint32_t vertex, std::uint32_t triangle);
  void add(std::uint32_t vertex, std::span<const std::uint32_t> triangles);

 private:
  struct Fan {
    std::uint32_t first = 0, count = 0, capacity = 0;
  };
  std::vector<Fan> fans_;
  std::vector<std::uint32_t> pool_;
};

/// Keeps its memory from block to block. Thread contract: one thread at a time.
class Simplifier {
 public:
  /// Collapses edges of mesh.triangles in place: a triangle that is gone names kNone thrice, the
  /// others keep their place and name the vertices that remain. No collapse makes a non-manifold
  /// edge, a triangle twice, or one that faces away from what it replaces; borders of the surface
  /// collapse along themselves only; vertices where the surface is no manifold stay.
  void run(SimplifyMesh& mesh, const SimplifyOptions& options);

  /// Of each vertex the one that it has become, itself where it stays.
  const std::vector<std::uint32_t>& parents() const { return parents_; }
  /// Of each vertex the area of its triangles before any collapsed.
  const std::vector<float>& areas() const { return areas_; }
  const VertexFans& fans() const { return fans_; }
  std::size_t triangle_count() const { return live_; }
  /// Whether a vertex was on a border of the surface before it went.
  bool is_border(std::uint32_t vertex) const { return kinds_[vertex] == Kind::kBorder; }
  /// Whether its triangles formed one closed fan and it was not locked.
  bool is_inside(std::uint32_t vertex) const { return kinds_[vertex] == Kind::kInside; }

 private:
  /// Symmetric 3 x 3 matrix A, vector b and number c of the squared distances to planes, weighted
  /// by area, as a function of d = point - own vertex: d'Ad + 2b'd + c. About the vertex itself
  /// floats are exact enough for any block.
  struct Quadric {
    float xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
    float bx = 0, by = 0, bz = 0, c = 0;
    float area = 0, unused = 0;
  };
  struct Ring;
  enum class Kind : std::uint8_t { kInside, kBorder, kFixed };

  void prepare();
  void add_plane_quadrics();
  void classify();
  void add_border_quadrics();
  void gather(std::uint32_t u, Ring& ring) const;
  void locate(std::uint32_t u, Ring& ring) const;
  void price(std::uint32_t u, Ring& ring) const;
  bool folds(int target, const Ring& ring) const;
  bool allowed(std::uint32_t u, std::uint32_t target, const Ring& ring);
  void guess(std::uint32_t u);
  void evaluate(std::uint32_t u, bool check_link, Ring& ring);
  void choose(std::uint32_t u, bool check_link, Ring& ring);
  bool collapse(std::uint32_t u, Ring& ring);
  void add_quadric(std::uint32_t u, std::uint32_t target);
  float threshold();
  std::size_t sweep(float threshold);

  SimplifyMesh* mesh_ = nullptr;
  SimplifyOptions options_;
  std::size_t live_ = 0;
  std::uint32_t sweep_ = 0, epoch_ = 0;
  VertexFans fans_;
  std::vector<Quadric> quadrics_;
  std::vector<Kind> kinds_;
  std::vector<float> areas_, costs_, reached_;
  std::vector<std::uint32_t> targets_, touched_, marks_, parents_;
};

}  // namespace cornice::hlod
