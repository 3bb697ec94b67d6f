// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/plane_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

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

/// Sums run over eight interleaved partial sums, an order that vector units of any width share.
Moments moments(const Neighbourhood& points) {
  constexpr std::uint32_t kLanes = 8;
  std::array<std::array<float, kLanes>, 9> lane{};
  const auto add = [&](std::uint32_t l, float x, float y, float z) {
    lane[0][l] += x, lane[1][l] += y, lane[2][l] += z;
    lane[3][l] += x * x, lane[4][l] += x * y, lane[5][l] += x * z;
    lane[6][l] += y * y, lane[7][l] += y * z, lane[8][l] += z * z;
  };
  std::uint32_t i = 0;
  for (; i + kLanes <= points.size; i += kLanes) {
    for (std::uint32_t l = 0; l < kLanes; ++l) {
      add(l, points.dx[i + l], points.dy[i + l], points.dz[i + l]);
    }
  }
  for (; i < points.size; ++i) add(i % kLanes, points.dx[i], points.dy[i], points.dz[i]);
  std::array<double, 9> sum;
  const double scale = 1.0 / static_cast<double>(points.size);
  for (std::size_t s = 0; s < sum.size(); ++s) {
    double total = 0.0;
    for (const float value : lane[s]) total += static_cast<double>(value);
    sum[s] = total * scale;
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
    if (step <= 1e-10 * smallest) break;
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
