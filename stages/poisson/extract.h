// SPDX-License-Identifier: GPL-3.0-or-later
// From the implicit function of a tile to its surface: triangles on the finest lattice.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/progress.h"
#include "core/base/vec.h"
#include "core/mesh/mesh.h"
#include "stages/poisson/field.h"

namespace cornice {

/// Nodes [x0, x1] x [y0, y1] of level 0 in plan; as a set of cells, those between them.
struct LatticeBox {
  std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  friend auto operator<=>(const LatticeBox&, const LatticeBox&) = default;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  LatticeBox grown(std::int32_t nodes) const {
    return {x0 - nodes, y0 - nodes, x1 + nodes, y1 + nodes};
  }
  /// True where the two share a node.
  bool touches(const LatticeBox& o) const {
    return x0 <= o.x1 && o.x0 <= x1 && y0 <= o.y1 && o.y0 <= y1;
  }
};

/// Values on the nodes of level 0: what the surface is extracted from. A node has one value,
/// whichever way it is asked for. Thread contract: const members may be called from many threads.
class NodeValues {
 public:
  virtual ~NodeValues() = default;
  /// The 512 nodes that a brick owns, x fastest, where they are kept as they are; else null.
  virtual const float* stored(BrickKey brick) const = 0;
  /// Computes those nodes; NaN where the function is not known. False where it is on none.
  virtual bool compute(BrickKey brick, std::span<float, kBrickNodes> values) const = 0;
  /// Bricks in the columns between first and last (x and y, inclusive) in which the sign changes:
  /// at least one of every connected piece of the surface. Sorted.
  virtual std::vector<BrickKey> crossing_bricks(BrickKey first, BrickKey last,
                                                int threads) const = 0;
};

inline constexpr std::int32_t kLowestNode = -(1 << 28);
inline constexpr std::int32_t kHighestNode = 1 << 28;

/// A field alone.
class FieldValues : public NodeValues {
 public:
  /// `field` must outlive this. Bricks without a node in [z0, z1] count as not known.
  explicit FieldValues(const Field& field, std::int32_t z0 = kLowestNode,
                       std::int32_t z1 = kHighestNode)
      : field_(&field), first_z_(z0 >> 3), last_z_(z1 >> 3) {}
  const float* stored(BrickKey brick) const override;
  bool compute(BrickKey brick, std::span<float, kBrickNodes> values) const override;
  std::vector<BrickKey> crossing_bricks(BrickKey first, BrickKey last, int threads) const override;

 private:
  bool is_known(BrickKey brick) const { return brick.z >= first_z_ && brick.z <= last_z_; }

  const Field* field_;
  std::int32_t first_z_, last_z_;  ///< bricks
};

/// Parts of a lattice step in which positions of vertices are whole numbers.
inline constexpr std::int32_t kUnitsPerStep = 1024;

struct ExtractOptions {
  LatticeBox window;  ///< cells to extract; the surface ends exactly on its border planes
  /// Tiles whose border planes touch the window. Vertices on these planes stay on them, so that
  /// every tile that meets there has the same ones. The window itself counts as one.
  std::vector<LatticeBox> borders;
  /// Vertices closer to a node than this part of a step are made one. [0, 0.49]; 0 leaves all
  /// apart. Near a half hardly a triangle keeps an angle below 20 degrees, and there are a quarter
  /// fewer of them (docs/decisions/0041-surface-extraction.md).
  double weld = 0.45;
  int threads = 0;  ///< 0: all cores
};

/// A surface. Positions are whole numbers of step / 1024 from mesh.origin, itself a node; where the
/// step is a power of two both are exact.
struct Surface {
  Mesh mesh;                        ///< unit normals along the gradient; no properties, no CRS
  std::size_t bricks = 0;           ///< that hold some of it
  std::size_t welded = 0;           ///< vertices made from several
  std::size_t centre_vertices = 0;  ///< put into loops that could not be cut into triangles
};

/// The zero set of `values` within the window, outside on the positive side. Closed and manifold
/// but where the window or the known part of the function ends. A cell's triangles depend on the
/// values within two nodes of it alone, and a vertex and its normal likewise, so windows that share
/// a border plane get the same vertices and edges there. The same for any number of threads.
/// Throws RunError where the window is too large for float positions or there are more than 2^31
/// vertices. About 100 bytes a vertex at its peak beside the values.
Surface extract_surface(const NodeValues& values, const Lattice& lattice,
                        const ExtractOptions& options, Progress& progress = no_progress());

}  // namespace cornice
