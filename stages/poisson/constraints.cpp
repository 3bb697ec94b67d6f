// SPDX-License-Identifier: GPL-3.0-or-later
// Constraints of M. Kazhdan, H. Hoppe, "Screened Poisson surface reconstruction", 2013: for node i
// the integral of grad B_i . V, with V = sum over nodes of v_j B_j and v_j the normals splatted
// around node j. All B are trilinear; their spaces are nested, so V of a coarse level is also one
// of every finer level, and what a fine level integrates can be restricted to a coarser one
// exactly.
#include "stages/poisson/constraints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "core/base/clones.h"
#include "core/base/parallel.h"

namespace cornice::poisson {
namespace {

constexpr std::size_t kBricksAtATime = 64;
constexpr int kSide = kBrickSide + 2;  ///< nodes -1 .. 8 of a brick
constexpr int kStride = 16;            ///< of rows
/// Where a row has node 0: a sample's four nodes then fit in, wherever near the brick it is.
constexpr int kFirst = 4;

/// A vector at every node of a brick and one node around.
struct Vectors {
  std::array<std::array<std::array<float, kStride>, kSide>, kSide> x, y,
      z;  ///< [z + 1][y + 1][x + kFirst]
};

/// V of one level, in the bricks where it is not zero.
struct VectorGrid {
  std::vector<BrickKey> bricks;
  BrickIndex index;
  std::vector<Vec3f> values;  ///< 512 a brick
};

/// What part of a sample of this depth is splatted on a level. Its parts add up to 1.
float share(float depth, int level, int levels) {
  if (level == levels - 1 && depth >= static_cast<float>(level)) return 1.0f;
  return std::max(0.0f, 1.0f - std::abs(depth - static_cast<float>(level)));
}

/// Cubic B-spline at the nodes -1 .. 2 of a cell, for a place in it.
std::array<float, 4> cubic(float t) {
  const float u = 1.0f - t;
  return {u * u * u / 6.0f, 2.0f / 3.0f - t * t * (1.0f - 0.5f * t),
          2.0f / 3.0f - u * u * (1.0f - 0.5f * u), t * t * t / 6.0f};
}

/// Adds v to the nodes around a place in the cell (x, y, z).
void add_spread(Vec3f v, Vec3f fraction, int x, int y, int z, Vectors& to) {
  const auto wx = cubic(fraction.x), wy = cubic(fraction.y), wz = cubic(fraction.z);
  for (int c = std::max(0, -z); c < std::min(4, kBrickSide + 2 - z); ++c) {
    for (int b = std::max(0, -y); b < std::min(4, kBrickSide + 2 - y); ++b) {
      const float yz = wy[b] * wz[c];
      const std::array<float, 4> w{wx[0] * yz, wx[1] * yz, wx[2] * yz, wx[3] * yz};
      const auto add = [&w](float* row, float part) {
        for (int a = 0; a < 4; ++a) row[a] += w[a] * part;
      };
      const int k = z + c, j = y + b, i = x - 1 + kFirst;
      add(to.x[k][j].data() + i, v.x);
      add(to.y[k][j].data() + i, v.y);
      add(to.z[k][j].data() + i, v.z);
    }
  }
}

/// Splats the samples around a brick with cubic B-splines: trilinear ones, which are narrower where
/// a sample is near a node, would make the surface wave with the lattice. False where there are
/// none, and `to` is then untouched.
bool splat(const SampleLevel& samples, BrickKey brick, int level, int levels, Vectors& to) {
  bool any = false;
  for_each_sample_near(samples, brick, -3, kBrickSide + 1,
                       [&](const Sample& s, int x, int y, int z) {
                         const float part = share(s.depth, level, levels);
                         const float length = norm(s.normal);
                         if (part <= 0.0f || length <= 0.0f) return;
                         if (!any) to = {};
                         any = true;
                         add_spread(s.normal * (part * s.area / s.weight), s.fraction, x, y, z, to);
                       });
  return any;
}

using Row = std::array<float, kBrickSide>;

/// Adds the divergence at the brick's own nodes. Along the axis of the derivative the integrals of
/// B'_i B_j are (1/2, 0, -1/2), along the others those of B_i B_j are (1, 4, 1) / 6.
CORNICE_CLONES
void add_divergence(const Vectors& v, float* constraints) {
  constexpr float side = 1.0f / 6.0f, middle = 4.0f / 6.0f;
  std::array<std::array<Row, kSide>, kSide> dx, my, mz;  // [z][y][x]
  for (int k = 0; k < kSide; ++k) {
    for (int j = 0; j < kSide; ++j) {
      const float *vx = v.x[k][j].data() + kFirst - 1, *vy = v.y[k][j].data() + kFirst - 1,
                  *vz = v.z[k][j].data() + kFirst - 1;
      for (int i = 0; i < kBrickSide; ++i) {
        dx[k][j][i] = 0.5f * (vx[i] - vx[i + 2]);
        my[k][j][i] = side * (vy[i] + vy[i + 2]) + middle * vy[i + 1];
        mz[k][j][i] = side * (vz[i] + vz[i + 2]) + middle * vz[i + 1];
      }
    }
  }
  std::array<std::array<Row, kBrickSide>, kSide> even, odd;
  for (int k = 0; k < kSide; ++k) {
    for (int j = 0; j < kBrickSide; ++j) {
      for (int i = 0; i < kBrickSide; ++i) {
        even[k][j][i] = side * (dx[k][j][i] + dx[k][j + 2][i]) + middle * dx[k][j + 1][i] +
                        0.5f * (my[k][j][i] - my[k][j + 2][i]);
        odd[k][j][i] = side * (mz[k][j][i] + mz[k][j + 2][i]) + middle * mz[k][j + 1][i];
      }
    }
  }
  for (int k = 0; k < kBrickSide; ++k) {
    for (int j = 0; j < kBrickSide; ++j) {
      float* to = constraints + kBrickSide * (j + kBrickSide * k);
      for (int i = 0; i < kBrickSide; ++i) {
        to[i] += side * (even[k][j][i] + even[k + 2][j][i]) + middle * even[k + 1][j][i] +
                 0.5f * (odd[k][j][i] - odd[k + 2][j][i]);
      }
    }
  }
}

/// V of the next coarser level at a brick's nodes and one around. False where it is zero.
bool interpolate(const VectorGrid& coarse, BrickKey brick, Vectors& to) {
  if (coarse.bricks.empty()) return false;
  bool near = false;
  for (int o = 0; o < 8; ++o) {
    const auto owner = [](int b, int side) { return (4 * b - 1 + 5 * side) >> 3; };
    near =
        near || coarse.index.find(coarse.bricks, {owner(brick.x, o & 1), owner(brick.y, o >> 1 & 1),
                                                  owner(brick.z, o >> 2)}) != BrickIndex::kNone;
  }
  if (!near) return false;
  constexpr int kWindow = 6;  // coarse nodes 4b - 1 .. 4b + 4
  std::array<Vec3f, kWindow * kWindow * kWindow> window{};
  bool any = false;
  for (int k = 0; k < kWindow; ++k) {
    for (int j = 0; j < kWindow; ++j) {
      for (int i = 0; i < kWindow; ++i) {
        const int x = 4 * brick.x - 1 + i, y = 4 * brick.y - 1 + j, z = 4 * brick.z - 1 + k;
        const std::uint32_t at = coarse.index.find(coarse.bricks, {x >> 3, y >> 3, z >> 3});
        if (at == BrickIndex::kNone) continue;
        const int node = (x & 7) | (y & 7) << 3 | (z & 7) << 6;
        const Vec3f value =
            coarse.values[std::size_t{at} * kBrickNodes + static_cast<std::size_t>(node)];
        window[i + kWindow * (j + kWindow * k)] = value;
        any = any || value != Vec3f{};
      }
    }
  }
  if (!any) return false;
  // Fine node n lies between the coarse nodes (n + 2) / 2 and (n + 3) / 2 of the window.
  for (int n = 0; n < kSide * kSide * kSide; ++n) {
    const int x = n % kSide, y = n / kSide % kSide, z = n / kSide / kSide;
    Vec3f sum;
    for (int o = 0; o < 8; ++o) {
      const int i = (x + 1 + (o & 1)) / 2, j = (y + 1 + (o >> 1 & 1)) / 2,
                k = (z + 1 + (o >> 2)) / 2;
      sum += window[i + kWindow * (j + kWindow * k)];
    }
    sum *= 0.125f;
    const int at = x - 1 + kFirst;
    to.x[z][y][at] = sum.x, to.y[z][y][at] = sum.y, to.z[z][y][at] = sum.z;
  }
  return true;
}

constexpr int kFine = 2 * kBrickSide + 1;  ///< fine nodes 16b - 1 .. 16b + 15
using FineWindow = std::array<float, kFine * kFine * kFine>;

/// Adds half of the fine nodes' sums with the weights (1, 2, 1) / 2 on each axis.
CORNICE_CLONES
void add_coarse(const FineWindow& fine, float* constraints) {
  constexpr int kRows = kFine * kFine;
  std::array<float, kRows * kBrickSide> x;
  for (int r = 0; r < kRows; ++r) {
    for (int i = 0; i < kBrickSide; ++i) {
      const float* from = fine.data() + kFine * r + 2 * i;
      x[kBrickSide * r + i] = 0.5f * (from[0] + from[2]) + from[1];
    }
  }
  std::array<float, kFine * kBrickNodes / kBrickSide> xy;
  for (int k = 0; k < kFine; ++k) {
    for (int j = 0; j < kBrickSide; ++j) {
      const float* from = x.data() + kBrickSide * (kFine * k + 2 * j);
      float* to = xy.data() + kBrickSide * (kBrickSide * k + j);
      for (int i = 0; i < kBrickSide; ++i)
        to[i] = 0.5f * (from[i] + from[i + 2 * kBrickSide]) + from[i + kBrickSide];
    }
  }
  constexpr int kPlane = kBrickSide * kBrickSide;
  for (int k = 0; k < kBrickSide; ++k) {
    const float* from = xy.data() + 2 * kPlane * k;
    float* to = constraints + kPlane * k;
    for (int i = 0; i < kPlane; ++i)
      to[i] += 0.5f * (0.5f * (from[i] + from[i + 2 * kPlane]) + from[i + kPlane]);
  }
}

/// Adds half of what the next finer level integrates: constraints are held over the spacing, which
/// doubles from level to level.
void add_restricted(const Grid& fine, BrickKey brick, float* constraints) {
  FineWindow window{};
  bool any = false;
  for (int n = 0; n < 27; ++n) {
    const int bx = n % 3 - 1, by = n / 3 % 3 - 1, bz = n / 9 - 1;
    const std::uint32_t at =
        fine.index.find(fine.bricks, {2 * brick.x + bx, 2 * brick.y + by, 2 * brick.z + bz});
    if (at == BrickIndex::kNone) continue;
    any = true;
    const float* from = fine.constraints.data() + std::size_t{at} * kBrickNodes;
    const auto begin = [](int b) { return b < 0 ? 7 : 0; };
    for (int z = begin(bz); z < 8; ++z) {
      for (int y = begin(by); y < 8; ++y) {
        for (int x = begin(bx); x < 8; ++x) {
          window[(8 * bx + x + 1) + kFine * ((8 * by + y + 1) + kFine * (8 * bz + z + 1))] =
              from[x + 8 * (y + 8 * z)];
        }
      }
    }
  }
  if (any) add_coarse(window, constraints);
}

/// V on `level`: what is splatted there and what comes from the coarser one.
VectorGrid make_vectors(const Grid& grid, const SampleLevel& samples, const VectorGrid& coarse,
                        int level, int levels, int threads) {
  VectorGrid made = parallel_reduce(
      grid.bricks.size(), kBricksAtATime, threads, VectorGrid{},
      [&](std::size_t begin, std::size_t end) {
        VectorGrid part;
        const auto here = std::make_unique<Vectors>(), above = std::make_unique<Vectors>();
        for (std::size_t b = begin; b < end; ++b) {
          const bool own = splat(samples, grid.bricks[b], level, levels, *here);
          const bool inherited = interpolate(coarse, grid.bricks[b], *above);
          if (!own && !inherited) continue;
          part.bricks.push_back(grid.bricks[b]);
          for (int n = 0; n < kBrickNodes; ++n) {
            const int x = n % 8 + kFirst, y = n / 8 % 8 + 1, z = n / 64 + 1;
            Vec3f v;
            if (own) v += {here->x[z][y][x], here->y[z][y][x], here->z[z][y][x]};
            if (inherited) v += {above->x[z][y][x], above->y[z][y][x], above->z[z][y][x]};
            part.values.push_back(v);
          }
        }
        return part;
      },
      [](VectorGrid& sum, const VectorGrid& part) {
        sum.bricks.insert(sum.bricks.end(), part.bricks.begin(), part.bricks.end());
        sum.values.insert(sum.values.end(), part.values.begin(), part.values.end());
      });
  made.index = BrickIndex(made.bricks);
  return made;
}

/// Calls body(brick, vectors, constraints) for all bricks of a grid.
template <class Body>
void for_each_brick(Grid& grid, int threads, Body body) {
  parallel_for(grid.bricks.size(), kBricksAtATime, threads,
               [&](std::size_t begin, std::size_t end) {
                 const auto vectors = std::make_unique<Vectors>();
                 for (std::size_t b = begin; b < end; ++b)
                   body(grid.bricks[b], *vectors, grid.constraints.data() + b * kBrickNodes);
               });
}

}  // namespace

void set_constraints(std::span<Grid> grids, std::span<const SampleLevel> samples, int threads) {
  const auto levels = static_cast<int>(grids.size());
  for (int l = 0; l < levels; ++l) {
    for_each_brick(grids[l], threads, [&](BrickKey brick, Vectors& v, float* constraints) {
      std::fill_n(constraints, kBrickNodes, 0.0f);
      if (splat(samples[l], brick, l, levels, v)) add_divergence(v, constraints);
      if (l > 0) add_restricted(grids[l - 1], brick, constraints);
    });
  }
  VectorGrid vectors;
  for (int l = levels - 1; l > 0; --l) {
    vectors = make_vectors(grids[l], samples[l], vectors, l, levels, threads);
    if (vectors.bricks.empty()) continue;
    for_each_brick(grids[l - 1], threads, [&](BrickKey brick, Vectors& v, float* constraints) {
      if (interpolate(vectors, brick, v)) add_divergence(v, constraints);
    });
  }
}

}  // namespace cornice::poisson
