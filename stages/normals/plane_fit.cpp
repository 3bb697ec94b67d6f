// SPDX-License-Identifier: GPL-3.0-or-later
// Everything is done for all lanes at once, in loops without branches over the lanes.
#include "stages/normals/plane_fit.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/clones.h"

namespace cornice::normals {
namespace {

/// Second smallest eigenvalue over the largest below which points count as lying on one line.
constexpr double kLineRatio = 1e-8;
constexpr int kMostRounds = 40;

using Doubles = std::array<double, kLanes>;
/// Half the lanes of floats: one AVX register, or two of SSE.
constexpr std::size_t kHalf = kLanes / 2;
using Floats = float __attribute__((vector_size(kHalf * sizeof(float))));

/// Symmetric 3 x 3 matrices, and what their eigenvalues need.
struct Matrices {
  Doubles xx, xy, xz, yy, yz, zz;
  Doubles mean_x, mean_y, mean_z;
  Doubles trace;  ///< of the covariance; the matrices are divided by it
  Doubles low, middle, high;
};

struct Normals {
  Doubles x, y, z;
};

[[gnu::always_inline]] inline void load(Floats& lanes, const float* from) {
  std::memcpy(&lanes, from, sizeof lanes);
}

/// Sums of d and of d d^T over the rows, of lanes [first, first + kHalf).
[[gnu::always_inline]] inline void sum_rows(const NeighbourBlock& block, std::size_t first,
                                            float (&sums)[9][kLanes]) {
  Floats s[9] = {};
  const float* x = block.dx() + first;
  const float* y = block.dy() + first;
  const float* z = block.dz() + first;
  for (std::size_t c = 0; c < block.rows() * kLanes; c += kLanes) {
    Floats dx, dy, dz;
    load(dx, x + c), load(dy, y + c), load(dz, z + c);
    s[0] += dx, s[1] += dy, s[2] += dz;
    s[3] += dx * dx, s[4] += dx * dy, s[5] += dx * dz;
    s[6] += dy * dy, s[7] += dy * dz, s[8] += dz * dz;
  }
  for (std::size_t k = 0; k < 9; ++k) std::memcpy(&sums[k][first], &s[k], sizeof s[k]);
}

/// Covariances with trace 1 (zero where all points coincide).
[[gnu::always_inline]] inline void covariances(const NeighbourBlock& block, Matrices& m) {
  float sums[9][kLanes];
  sum_rows(block, 0, sums);
  sum_rows(block, kHalf, sums);
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double scale = 1.0 / std::max(static_cast<double>(block.sizes()[l]), 1.0);
    const auto mean = [&](std::size_t k) { return scale * static_cast<double>(sums[k][l]); };
    const double x = mean(0), y = mean(1), z = mean(2);
    const double xx = mean(3) - x * x, yy = mean(6) - y * y, zz = mean(8) - z * z;
    const double trace = xx + yy + zz;
    const double per_trace = trace > 0.0 ? 1.0 / trace : 0.0;
    m.mean_x[l] = x, m.mean_y[l] = y, m.mean_z[l] = z;
    m.xx[l] = xx * per_trace, m.yy[l] = yy * per_trace, m.zz[l] = zz * per_trace;
    m.xy[l] = (mean(4) - x * y) * per_trace;
    m.xz[l] = (mean(5) - x * z) * per_trace;
    m.yz[l] = (mean(7) - y * z) * per_trace;
    m.trace[l] = trace;
  }
}

/// Eigenvalues of positive semi-definite matrices with trace 1. Newton's iteration on the
/// characteristic polynomial from 0 rises monotonically to the smallest root; the other two follow
/// from a quadratic equation.
[[gnu::always_inline]] inline void eigenvalues(Matrices& m) {
  Doubles minors, det, live;
  for (std::size_t l = 0; l < kLanes; ++l) {
    minors[l] = m.xx[l] * m.yy[l] - m.xy[l] * m.xy[l] + m.xx[l] * m.zz[l] - m.xz[l] * m.xz[l] +
                m.yy[l] * m.zz[l] - m.yz[l] * m.yz[l];
    det[l] = m.xx[l] * (m.yy[l] * m.zz[l] - m.yz[l] * m.yz[l]) -
             m.xy[l] * (m.xy[l] * m.zz[l] - m.yz[l] * m.xz[l]) +
             m.xz[l] * (m.xy[l] * m.yz[l] - m.yy[l] * m.xz[l]);
    m.low[l] = 0.0;
    live[l] = 1.0;
  }
  bool any = true;
  for (int round = 0; round < kMostRounds && any; ++round) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double s = m.low[l];
      const double value = ((1.0 - s) * s - minors[l]) * s + det[l];
      const double slope = minors[l] - (2.0 - 3.0 * s) * s;
      const double positive = std::min(slope, value) > 0.0 ? live[l] : 0.0;
      const double step = positive > 0.0 ? value / slope : 0.0;
      m.low[l] = s + step;
      // Convergence is quadratic: the next step would be below 1e-12 of the root.
      live[l] = step > 1e-6 * m.low[l] ? positive : 0.0;
    }
    any = std::any_of(live.begin(), live.end(), [](double v) { return v > 0.0; });
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double half_sum = 0.5 * (1.0 - m.low[l]);
    const double product = minors[l] - m.low[l] * (1.0 - m.low[l]);
    const double root = std::sqrt(std::max(half_sum * half_sum - product, 0.0));
    m.middle[l] = half_sum - root;
    m.high[l] = half_sum + root;
  }
}

/// Null vectors of m - low * identity: the longest cross product of two of the rows. Zero where all
/// rows are parallel (a double eigenvalue).
[[gnu::always_inline]] inline void eigenvectors(const Matrices& m, Normals& n) {
  for (std::size_t l = 0; l < kLanes; ++l) {
    const Vec3d a{m.xx[l] - m.low[l], m.xy[l], m.xz[l]};
    const Vec3d b{m.xy[l], m.yy[l] - m.low[l], m.yz[l]};
    const Vec3d c{m.xz[l], m.yz[l], m.zz[l] - m.low[l]};
    const Vec3d ab = cross(a, b), ac = cross(a, c), bc = cross(b, c);
    const double ab_sq = dot(ab, ab), ac_sq = dot(ac, ac), bc_sq = dot(bc, bc);
    const bool second = ac_sq > ab_sq;
    const double two_sq = second ? ac_sq : ab_sq;
    const bool third = bc_sq > two_sq;
    const double best_sq = third ? bc_sq : two_sq;
    const double scale = best_sq > 0.0 ? 1.0 / std::sqrt(best_sq) : 0.0;
    const double x = third ? bc.x : (second ? ac.x : ab.x);
    const double y = third ? bc.y : (second ? ac.y : ab.y);
    const double z = third ? bc.z : (second ? ac.z : ab.z);
    // The first of z, y, x that is not zero decides the sign.
    const double lead = z != 0.0 ? z : (y != 0.0 ? y : x);
    const double sign = lead < 0.0 ? -scale : scale;
    n.x[l] = x * sign, n.y[l] = y * sign, n.z[l] = z * sign;
  }
}

[[gnu::always_inline]] inline void finish_planes(const NeighbourBlock& block, const Matrices& m,
                                                 const Normals& n, PlaneBlock& planes) {
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double x = n.x[l], y = n.y[l], z = n.z[l];
    const double off_plane = x * m.mean_x[l] + y * m.mean_y[l] + z * m.mean_z[l];
    const double low = std::max(m.low[l], 0.0), middle = m.middle[l], high = m.high[l];
    const double enough = block.sizes()[l] >= 3 ? m.trace[l] : 0.0;
    const double broad = middle > kLineRatio * high ? enough : 0.0;
    const double exists = x * x + y * y + z * z > 0.5 ? broad : 0.0;
    const double some = exists > 0.0 ? 1.0 : 0.0;
    const double q1 = 1.0 - std::min(low / middle, 1.0);
    const double q2 = std::max(1.0 - 3.0 * off_plane * off_plane / (high * m.trace[l]), 0.0);
    const double quality = exists > 0.0 ? q1 * q2 : 0.0;
    planes.normal_x[l] = static_cast<float>(x * some);
    planes.normal_y[l] = static_cast<float>(y * some);
    planes.normal_z[l] = static_cast<float>(z * some);
    planes.quality[l] = static_cast<float>(quality);
    planes.breadth_m[l] = static_cast<float>(std::sqrt(std::max(middle, 0.0) * exists));
    planes.spread_m[l] = static_cast<float>(std::sqrt(low * exists));
  }
}

}  // namespace

CORNICE_CLONES
void fit_planes(const NeighbourBlock& block, PlaneBlock& planes) {
  Matrices m;
  Normals n;
  covariances(block, m);
  eigenvalues(m);
  eigenvectors(m, n);
  finish_planes(block, m, n, planes);
}

PlaneFit fit_plane(const Neighbourhood& neighbours) {
  NeighbourBlock block;
  block.add(0, neighbours);
  block.finish();
  PlaneBlock planes;
  fit_planes(block, planes);
  return planes.plane(0);
}

}  // namespace cornice::normals
