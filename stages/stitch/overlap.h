// SPDX-License-Identifier: GPL-3.0-or-later
// Tiles that lie over each other: how much, and cutting them apart.
//
//        a ────────────────────┬─ ─ ─ ─ ─
//                 ─ ─ ─ ─ ─ ─ ─┴──────────────────── b
//                        │◄─ overlap ─►│      each keeps its side of the middle
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/mesh.h"

namespace cornice::stitch {

/// The highest surface of a mesh over a grid of places: not a number where there is none.
class Heights {
 public:
  /// Cells of at least half a metre, at most 128 to a side.
  explicit Heights(const Box2d& area);
  void add(const Mesh& mesh);
  /// Area in which both have surface within a metre of each other. Both are over the same area.
  double area_shared_with(const Heights& other) const;

 private:
  Box2d area_;
  int columns_ = 1, rows_ = 1;
  double width_m_ = 1.0, height_m_ = 1.0;  ///< of a cell
  std::vector<float> z_;
};

/// Part of the plan that two boxes share; empty where they share less than a metre either way.
Box2d shared_area(const Box3d& a, const Box3d& b);

/// Keeps what lies on one side of a plane x = at (axis 0) or y = at (axis 1), projected CRS.
struct Cut {
  int axis = 0;
  double at = 0.0;  ///< a multiple of 1/1024 m
  bool keeps_below = true;
};

/// The cuts that give each of two tiles its side of the middle of what they share: along the axis
/// in which they share less. False where that is more than half of one of them: no neighbours.
bool cut_apart(const Box3d& a, const Box3d& b, Cut& cut_a, Cut& cut_b);

/// The part of a mesh that all cuts keep. New vertices lie on the planes exactly, with attributes
/// between those of their edge's ends; of bytes the larger.
Mesh cut_mesh(const Mesh& mesh, std::span<const Cut> cuts);

}  // namespace cornice::stitch
