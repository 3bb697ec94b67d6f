// SPDX-License-Identifier: GPL-3.0-or-later
// The equations of one brick's nodes, and the values that they need from around it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/poisson/grid.h"
#include "stages/poisson/screening.h"

namespace cornice::poisson {

inline constexpr int kHaloSide = kBrickSide + 2;
inline constexpr int kHaloRow = 16;                      ///< floats from row to row of a halo
inline constexpr int kHaloPlane = kHaloSide * kHaloRow;  ///< from plane to plane
inline constexpr int kHaloFirst = 4;  ///< where node 0 of a row is, with room for node -1
/// Trilinear stiffness over the spacing: the node itself, neighbours across an edge of a cell's
/// face, neighbours across a cell; those along an axis take no part.
inline constexpr float kCentre = 8.0f / 3.0f, kEdge = 1.0f / 6.0f, kCorner = 1.0f / 12.0f;

/// Values of a brick's nodes and one around. Zeros at first, so that what is never loaded is a
/// number.
struct alignas(64) Halo {
  std::array<float, kHaloSide * kHaloPlane> values{};
  float* row(int y, int z) {
    return values.data() + kHaloPlane * (z + 1) + kHaloRow * (y + 1) + kHaloFirst;
  }
  const float* row(int y, int z) const { return const_cast<Halo*>(this)->row(y, z); }
};

/// What one brick's equations are made of.
struct Equations {
  const float* constraints;
  const RowMasks* active;
  std::span<const Tie> ties;
  int low = kBrickSide, high = -1;  ///< planes with active nodes

  Equations(const Grid& grid, const std::vector<float>& right_side, const Screening& screening,
            std::size_t brick)
      : constraints(right_side.data() + brick * kBrickNodes),
        active(&grid.active[brick]),
        ties(screening.ties(brick)) {
    for (int r = 0; r < kBrickRows; ++r) {
      if ((*active)[r] == 0) continue;
      low = std::min(low, r >> 3);
      high = r >> 3;
    }
  }
};

/// Copies the planes [low, high] of a brick's nodes and the ones around it. What is not stored
/// stays as it is.
void load_stored(const Grid& grid, std::size_t brick, int low, int high, Halo& halo);

/// All that a brick's equations need; a whole grid's borders reflect.
void load(const Grid& grid, std::size_t brick, const Equations& equations, Halo& halo);

using Row = std::array<float, kBrickSide>;
/// A row and the node before and behind it, which ties of the cells there also name.
using WideRow = std::array<float, kHaloSide>;

/// How a brick's ties pull. The field at each is kept up to date as nodes move, so that a row costs
/// its own ties only.
class Pull {
 public:
  void start(const Halo& halo, const Equations& equations) {
    ties_ = equations.ties;
    std::size_t t = 0;
    for (int row = 0; row <= kTieRows; ++row) {
      while (t < ties_.size() && ties_[t].row < row) ++t;
      first_[row] = static_cast<std::uint16_t>(t);
    }
    for (t = 0; t < ties_.size(); ++t) {
      const Tie& tie = ties_[t];
      const int y = tie.row % kTieSide - 1, z = tie.row / kTieSide - 1;
      const Vec3f f = tie.fraction;
      const auto along = [&](int j, int k) {
        const float* own = halo.row(y + j, z + k) + tie.x;
        return (1.0f - f.x) * own[0] + f.x * own[1];
      };
      field_[t] = (1.0f - f.z) * ((1.0f - f.y) * along(0, 0) + f.y * along(1, 0)) +
                  f.z * ((1.0f - f.y) * along(0, 1) + f.y * along(1, 1));
    }
  }

  /// Takes the pull off what a row lacks, and, where asked, adds up how it stiffens each node:
  /// ties between nodes of the row are counted with the node itself, as all of them move at once.
  template <bool kStiffness>
  void apply(int y, int z, WideRow& lacking, WideRow& stiffness) const {
    for_each(y, z, [&](std::size_t t, const Tie& tie, float yz) {
      const float pull = tie.strength * yz;
      const float right = tie.fraction.x, left = 1.0f - right;
      const std::size_t i = static_cast<std::size_t>(tie.x + 1);
      lacking[i] -= pull * left * field_[t];
      lacking[i + 1] -= pull * right * field_[t];
      if constexpr (kStiffness) {
        stiffness[i] += pull * yz * left;
        stiffness[i + 1] += pull * yz * right;
      }
    });
  }

  /// The nodes of a row have moved.
  void follow(int y, int z, const WideRow& moved) {
    for_each(y, z, [&](std::size_t t, const Tie& tie, float yz) {
      const float right = tie.fraction.x;
      const std::size_t i = static_cast<std::size_t>(tie.x + 1);
      field_[t] += yz * ((1.0f - right) * moved[i] + right * moved[i + 1]);
    });
  }

 private:
  /// Calls use(index, tie, weight of the row in the tie) for the ties of the four rows of cells
  /// around a row of nodes.
  template <class Use>
  void for_each(int y, int z, Use use) const {
    for (int o = 0; o < 4; ++o) {
      const int above_y = o & 1, above_z = o >> 1;
      const int row = (y + above_y) + kTieSide * (z + above_z);
      for (std::size_t t = first_[row]; t < first_[row + 1]; ++t) {
        const Vec3f f = ties_[t].fraction;
        use(t, ties_[t], (above_y ? 1.0f - f.y : f.y) * (above_z ? 1.0f - f.z : f.z));
      }
    }
  }

  std::span<const Tie> ties_;
  std::array<std::uint16_t, kTieRows + 1> first_;
  std::array<float, kTiesMax> field_;
};

/// What the equations of one row's nodes lack but for screening: constraint less stiffness applied
/// to the values. The first and last entries are zero.
inline void row_residual(const float* own, const float* constraint, WideRow& lacking) {
  const float *a = own - kHaloRow, *b = own + kHaloRow, *c = own - kHaloPlane,
              *d = own + kHaloPlane;
  const float *e = c - kHaloRow, *f = c + kHaloRow, *g = d - kHaloRow, *h = d + kHaloRow;
  lacking[0] = lacking[kHaloSide - 1] = 0.0f;
  for (int i = 0; i < kBrickSide; ++i) {
    const float edges = ((a[i - 1] + a[i + 1]) + (b[i - 1] + b[i + 1])) +
                        ((c[i - 1] + c[i + 1]) + (d[i - 1] + d[i + 1])) +
                        ((e[i] + f[i]) + (g[i] + h[i]));
    const float corners = ((e[i - 1] + e[i + 1]) + (f[i - 1] + f[i + 1])) +
                          ((g[i - 1] + g[i + 1]) + (h[i - 1] + h[i + 1]));
    lacking[i + 1] = (constraint[i] - kCentre * own[i]) + (kEdge * edges + kCorner * corners);
  }
}

}  // namespace cornice::poisson
