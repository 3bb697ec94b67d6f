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
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/topology.h"
#include "hlod/simplify_links.h"

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

/// Keeps its memory from block to block. Thread contract: one thread at a time.
class Simplifier {
 public:
  /// Collapses edges of mesh.triangles in place: a triangle that is gone names kNone thrice, the
  /// others keep their place and name the vertices that remain. No collapse makes a non-manifold
  /// edge, a triangle twice, or one that faces away from what it replaces; borders of the surface
  /// collapse along themselves only; vertices where the surface is no manifold stay.
  void run(SimplifyMesh& mesh, const SimplifyOptions& options);
  /// The same, but the triangles stay as they are: parents() says what became of their corners.
  void collapse_edges(const SimplifyMesh& mesh, const SimplifyOptions& options);

  /// Of each vertex the one that it has become, itself where it stays.
  const std::vector<std::uint32_t>& parents() const { return parents_; }
  /// Of each vertex the area of its triangles before any collapsed.
  const std::vector<float>& areas() const { return areas_; }
  /// What lies round the vertices that are left.
  const VertexLinks& links() const { return links_; }
  /// Of each vertex x, y, z and a number of the simplifier's own.
  const std::vector<Float4>& places() const { return places_; }
  std::size_t triangle_count() const { return live_; }
  bool is_in_plan() const { return options_.in_plan; }
  /// Whether a vertex was on a border of the surface before it went.
  bool is_border(std::uint32_t vertex) const { return kinds_[vertex] == Kind::kBorder; }
  /// Whether its triangles formed one closed fan and it was not locked.
  bool is_inside(std::uint32_t vertex) const { return kinds_[vertex] == Kind::kInside; }

 private:
  /// Symmetric 3 x 3 matrix A, vector b and number c of the squared distances to planes, weighted
  /// by area, as a function of d = point - own vertex: d'Ad + 2b'd + c. About the vertex itself
  /// floats are exact enough for any block.
  struct Quadric {
    Float4 squares{};   ///< xx, yy, zz, unused
    Float4 products{};  ///< xy, xz, yz, area
    Float4 rest{};      ///< b, c
  };
  /// What a vertex would cost, and in which sweep a neighbour of it went last.
  struct State {
    float cost;
    std::uint32_t touched;
  };
  struct Ring;
  enum class Kind : std::uint8_t { kInside, kBorder, kFixed };

  void prepare();
  void add_plane_quadrics();
  void classify();
  void add_border_quadric(std::uint32_t u);
  float guess(std::uint32_t u) const;
  void gather(std::uint32_t u, Ring& ring) const;
  void locate(std::uint32_t u, Ring& ring) const;
  void price(std::uint32_t u, Ring& ring) const;
  void price_further(std::uint32_t u, Ring& ring) const;
  bool folds(float tx, float ty, float tz, std::uint32_t place, const Ring& ring) const;
  bool allowed(std::uint32_t place, const Ring& ring) const;
  float way(float x, float y, float z) const;
  bool evaluate(std::uint32_t u, bool check_links, Ring& ring);
  bool collapse(std::uint32_t u, Ring& ring);
  void add_quadric(std::uint32_t u, std::uint32_t target);
  float threshold();
  std::size_t sweep(float bound);
  void prefetch(std::size_t i, std::size_t count) const;

  const SimplifyMesh* mesh_ = nullptr;
  SimplifyOptions options_;
  std::size_t live_ = 0;
  std::uint32_t sweep_ = 0;
  VertexLinks links_;
  std::vector<Float4> places_;  ///< x, y, z; the longest way of what the vertex stands for
  std::vector<Quadric> quadrics_;
  std::vector<State> states_;
  std::vector<Kind> kinds_;
  std::vector<float> areas_;
  std::vector<std::uint32_t> targets_, candidates_, gone_, parents_;
};

}  // namespace cornice::hlod
