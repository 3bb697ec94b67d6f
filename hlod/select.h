// SPDX-License-Identifier: GPL-3.0-or-later
// Which cells to draw. One radius per level decides: a cell of level l is drawn where it is at
// least D_l away from the eye (or has nothing finer) and its parent is not. Whatever should change
// the level of detail moves radii: the error on the screen, a budget of triangles, what is loaded.
// They move continuously with eye and time, so nothing pops; docs/decisions/0600-radii.md.
//
// Everything here is a function of its arguments. A viewer keeps the tree, the radii of the frame
// before and a Selection, whose memory is used again.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "hlod/cell.h"
#include "hlod/file.h"
#include "hlod/morph.h"

namespace cornice::hlod {

/// A cell as selection sees it. Children lie side by side in the tree.
struct TreeCell {
  CellKey key;
  FinePoint lowest, highest;      ///< box of what it and all below it may draw, fine steps
  float error_m = 0;              ///< never below a child's
  std::uint32_t triangles = 0;    ///< of all parts
  std::uint32_t first_child = 0;  ///< index into the tree
  std::uint32_t first_node = 0;   ///< of its parts in the file's nodes
  std::uint32_t first_error = 0;  ///< of Tree::errors; up to the next cell's are its own
  std::uint16_t parts = 0;        ///< 0: nothing is left of it at this level, finer cells are there
  std::uint16_t children = 0;
};

/// All cells, coarsest level first. 66 bytes a cell: 64 km x 64 km with 1.2 M triangles a square
/// kilometre in cells of 5000 are 1.3 M cells, 86 MB.
struct Tree {
  Lattice lattice;
  Metric metric;
  std::vector<TreeCell> cells;
  std::array<std::uint32_t, kLevelLimit + 1> level_begin{};  ///< index of a level's first cell
  /// Of each cell that has children, by level from its own on, the largest error of the cells with
  /// children among it and those below it.
  std::vector<float> errors;

  std::span<const float> errors_of(std::size_t cell) const;
  std::span<const TreeCell> level(int l) const;
};

/// `nodes` sorted by key and part, as File::nodes().
Tree make_tree(const Header& header, std::span<const Node> nodes);

/// Distance of the eye to a cell, as radii are compared with; fine steps.
std::int32_t cell_distance(const Tree& tree, const TreeCell& cell, FinePoint eye);

/// How many times further away than it is large an error may be seen: pixels of a viewport that
/// subtends `field_of_view_deg` along that side, over pixels that an error may cover.
double error_scale(double error_pixels, double viewport_pixels, double field_of_view_deg);

/// Radii for an eye: no cell within sight draws an error larger than its distance over `scale`.
/// Continuous, at most twice as fast as the eye. Looks only at cells that may have a say, by
/// Tree::errors.
Radii radii_for_eye(const Tree& tree, double scale, FinePoint eye);

/// D_l = factor * cell side, the thesis's rule. factor >= 1 + 3 s0 + 1/16; lower is raised to it.
Radii radii_by_factor(const Metric& metric, double factor);

/// The smallest change (only downwards) after which the radii obey their rule, and those at or
/// below 0 are as large as they may be.
void settle(Radii& radii, const Metric& metric);
bool obeys_rule(const Radii& radii, const Metric& metric);

/// share * radii, settled; share in 0..1.
Radii scaled(const Radii& radii, double share, const Metric& metric);
/// from + share * (to - from), settled; share in 0..1. For motion in time.
Radii blended(const Radii& from, const Radii& to, double share, const Metric& metric);

/// Half-spaces a x + b y + c z + d >= 0 of fine steps seen from the eye. Empty: everything. Without
/// memory of its own, for there are several each frame.
class Frustum {
 public:
  using Plane = std::array<double, 4>;
  static constexpr std::size_t kMostPlanes = 10;

  void add(const Plane& plane) {
    assert(count_ < kMostPlanes);
    planes_[count_++] = plane;
  }
  void add(const Frustum& other) {
    for (const Plane& plane : other.planes()) add(plane);
  }
  std::span<const Plane> planes() const { return {planes_.data(), count_}; }

 private:
  std::array<Plane, kMostPlanes> planes_{};
  std::size_t count_ = 0;
};
/// Of a camera with unit axes `forward` and `up` (need not be square to it); full angles, below
/// 180.
Frustum make_frustum(Vec3d forward, Vec3d up, double horizontal_deg, double vertical_deg);

struct WalkMemory {
  std::vector<std::uint32_t> cells, below;  ///< memory that hold_to_loaded() uses again
};
/// Lowers radii until only cells that are loaded are drawn inside the frustum. is_loaded: one byte
/// per cell, and all ancestors of a loaded cell are loaded; level 0 counts as loaded. Continuous in
/// the eye's place, not in its direction: load more than is seen.
void hold_to_loaded(const Tree& tree, std::span<const std::uint8_t> is_loaded, FinePoint eye,
                    const Frustum& frustum, Radii& radii, WalkMemory& memory);
inline void hold_to_loaded(const Tree& tree, std::span<const std::uint8_t> is_loaded, FinePoint eye,
                           const Frustum& frustum, Radii& radii) {
  WalkMemory memory;
  hold_to_loaded(tree, is_loaded, eye, frustum, radii, memory);
}

/// What to draw.
struct Selection {
  std::vector<std::uint32_t> cells;  ///< indices into the tree; coarse to fine within a branch
  std::uint64_t triangles = 0;

  std::vector<std::uint32_t> stack;  ///< memory that select() uses again
};
void select(const Tree& tree, const Radii& radii, FinePoint eye, const Frustum& frustum,
            Selection& selection);

/// The largest share, to a part in 256, whose scaled() radii draw at most `budget` triangles.
double share_for_budget(const Tree& tree, const Radii& radii, FinePoint eye, const Frustum& frustum,
                        std::uint64_t budget, Selection& scratch);

/// All cells that drawing by `radii` takes, ancestors and siblings too, coarse before fine. Takes
/// the place of what is in `cells`.
void needed_cells(const Tree& tree, const Radii& radii, FinePoint eye, const Frustum& frustum,
                  std::vector<std::uint32_t>& cells);

/// Of those the ones that are not loaded, the most urgent first: coarse before fine, near
/// before far. Pass radii before hold_to_loaded. `frustum` of what is soon to be seen.
std::vector<std::uint32_t> wanted_cells(const Tree& tree, std::span<const std::uint8_t> is_loaded,
                                        const Radii& radii, FinePoint eye, const Frustum& frustum);

struct UrgencyMemory {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  ///< keep_most_urgent() uses it again
};
/// Leaves the `most` first of them: coarse before fine, near before far.
void keep_most_urgent(const Tree& tree, FinePoint eye, std::size_t most,
                      std::vector<std::uint32_t>& cells, UrgencyMemory& memory);

}  // namespace cornice::hlod
