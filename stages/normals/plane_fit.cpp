// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/plane_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace cornice::normals {
namespace {

/// Second smallest eigenvalue over the largest below which points count as lying on one line.
constexpr double kLineRatio = 1e-8;

/// Symmetric 3 x 3 matrix.
struct Symmetric {
  double xx, xy, xz, yy, yz, zz;
};

struct Moments {
  Symmetric covariance;
  Vec3d mean;
};

/// Four floats that are worked on together: SSE registers here, four plain floats elsewhere.
constexpr std::uint32_t kLanes = 4;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));

/// values[0..count) and zeros, count <= kLanes.
Lanes load(const float* values, std::uint32_t count) {
  Lanes lanes{};
  std::memcpy(&lanes, values, count * sizeof(float));
  return lanes;
}

/// Sums run over four interleaved partial sums, an order that does not depend on the machine.
Moments moments(const Neighbourhood& points) {
  std::array<Lanes, 9> lane{};
  const auto add = [&](Lanes x, Lanes y, Lanes z) {
    lane[0] += x, lane[1] += y, lane[2] += z;
    lane[3] += x * x, lane[4] += x * y, lane[5] += x * z;
    lane[6] += y * y, lane[7] += y * z, lane[8] += z * z;
  };
  std::uint32_t i = 0;
  for (; i + kLanes <= points.size; i += kLanes) {
    add(load(points.dx + i, kLanes), load(points.dy + i, kLanes), load(points.dz + i, kLanes));
  }
  const std::uint32_t rest = points.size - i;
  if (rest > 0)
    add(load(points.dx + i, rest), load(points.dy + i, rest), load(points.dz + i, rest));
  std::array<double, 9> sum;
  const double scale = 1.0 / static_cast<double>(points.size);
  for (std::size_t s = 0; s < sum.size(); ++s) {
    sum[s] = scale * static_cast<double>((lane[s][0] + lane[s][1]) + (lane[s][2] + lane[s][3]));
  }
  const Vec3d mean{sum[0], sum[1], sum[2]};
  return {{sum[3] - mean.x * mean.x, sum[4] - mean.x * mean.y, sum[5] - mean.x * mean.z,
           sum[6] - mean.y * mean.y, sum[7] - mean.y * mean.z, sum[8] - mean.z * mean.z},
          mean};
}

/// Eigenvalues in ascending order of a positive semi-definite matrix with trace 1. Newton's
/// iteration on the characteristic polynomial from 0 rises monotonically to the smallest root; the
/// other two follow from a quadratic equation.
std::array<double, 3> eigenvalues(const Symmetric& m) {
  const double trace = m.xx + m.yy + m.zz;
  const double minors =
      m.xx * m.yy - m.xy * m.xy + m.xx * m.zz - m.xz * m.xz + m.yy * m.zz - m.yz * m.yz;
  const double det = m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz) +
                     m.xz * (m.xy * m.yz - m.yy * m.xz);
  double smallest = 0.0;
  for (int round = 0; round < 40; ++round) {
    const double value = ((trace - smallest) * smallest - minors) * smallest + det;
    const double slope = minors - (2.0 * trace - 3.0 * smallest) * smallest;
    if (!(slope > 0.0) || !(value > 0.0)) break;
    const double step = value / slope;
    smallest += step;
    // Convergence is quadratic: the next step would be below 1e-12 of the root.
    if (step <= 1e-6 * smallest) break;
  }
  const double half_sum = 0.5 * (trace - smallest);
  const double product = minors - smallest * (trace - smallest);
  const double root = std::sqrt(std::max(half_sum * half_sum - product, 0.0));
  return {smallest, half_sum - root, half_sum + root};
}

/// Null vector of m - value * identity: the longest cross product of two of its rows. Zero where
/// all rows are parallel (a double eigenvalue).
Vec3d eigenvector(const Symmetric& m, double value) {
  const Vec3d a{m.xx - value, m.xy, m.xz}, b{m.xy, m.yy - value, m.yz}, c{m.xz, m.yz, m.zz - value};
  const std::array<Vec3d, 3> products{cross(a, b), cross(a, c), cross(b, c)};
  Vec3d best;
  for (const Vec3d& product : products) {
    if (dot(product, product) > dot(best, best)) best = product;
  }
  return normalized(best);
}

bool points_down(Vec3d n) {
  if (n.z != 0.0) return n.z < 0.0;
  return n.y != 0.0 ? n.y < 0.0 : n.x < 0.0;
}

}  // namespace

PlaneFit fit_plane(const Neighbourhood& neighbours) {
  PlaneFit fit;
  if (neighbours.size < 3) return fit;
  auto [m, mean] = moments(neighbours);
  const double trace = m.xx + m.yy + m.zz;
  if (!(trace > 0.0)) return fit;
  for (double* entry : {&m.xx, &m.xy, &m.xz, &m.yy, &m.yz, &m.zz}) *entry /= trace;
  const auto [l0, l1, l2] = eigenvalues(m);
  if (!(l1 > kLineRatio * l2)) return fit;
  Vec3d normal = eigenvector(m, l0);
  if (!(dot(normal, normal) > 0.5)) return fit;
  if (points_down(normal)) normal = -normal;
  const double off_plane_sq = dot(normal, mean) * dot(normal, mean);
  const double q1 = 1.0 - std::clamp(l0 / l1, 0.0, 1.0);
  const double q2 = std::max(1.0 - 3.0 * off_plane_sq / (l2 * trace), 0.0);
  fit.normal = normal.cast<float>();
  fit.quality = static_cast<float>(q1 * q2);
  fit.breadth_m = static_cast<float>(std::sqrt(l1 * trace));
  fit.spread_m = static_cast<float>(std::sqrt(std::max(l0, 0.0) * trace));
  return fit;
}

}  // namespace cornice::normals
