// SPDX-License-Identifier: GPL-3.0-or-later
// Uniform cubic B-splines, C2 everywhere: the smooth fields that a scene is made of.
// de Boor, A Practical Guide to Splines, 1978; the control values are the samples themselves, which
// damps waves shorter than about four steps and so limits the band of what they carry.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cornice::simulate {

/// Weights of the four control values around a place, and their derivatives by the cell's own
/// coordinate t in [0, 1).
template <class T>
struct CubicWeights {
  std::array<T, 4> w;
  std::array<T, 4> d;

  explicit CubicWeights(T t) {
    const T s = T(1) - t;
    const T t2 = t * t;
    const T s2 = s * s;
    constexpr T kSixth = T(1) / T(6);
    w = {s2 * s * kSixth, (T(4) + T(3) * t2 * (t - T(2))) * kSixth,
         (T(4) + T(3) * s2 * (s - T(2))) * kSixth, t2 * t * kSixth};
    d = {-s2 * T(0.5), t * (T(1.5) * t - T(2)), s * (T(2) - T(1.5) * s), t2 * T(0.5)};
  }
};

/// The same with three values: C1, cheaper. t in [0, 1) from the middle between the first two.
struct QuadraticWeights {
  std::array<float, 3> w;
  std::array<float, 3> d;

  explicit QuadraticWeights(float t) {
    const float s = 1.0f - t;
    w = {0.5f * s * s, 0.5f + t * s, 0.5f * t * t};
    d = {-s, 1.0f - 2.0f * t, t};
  }
};

/// Largest integer not above v; a cast, because std::floor is a call where there is no SSE 4.1.
inline std::int64_t floor_of(double v) {
  const auto i = static_cast<std::int64_t>(v);
  return i - (v < static_cast<double>(i) ? 1 : 0);
}

/// A lattice in plan, x fastest; node (i, j) lies at (x0 + i step, y0 + j step).
struct PlanLattice {
  double x0 = 0.0;
  double y0 = 0.0;
  double step = 1.0;
  int nx = 0;
  int ny = 0;
  double per_metre = 1.0 / step;

  std::size_t size() const { return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny); }
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i);
  }
  double x(int i) const { return x0 + i * step; }
  double y(int j) const { return y0 + j * step; }
};

/// The 4 x 4 neighbourhood of a place: index of its first node and the offsets within the cell.
/// Places outside the lattice are taken at its border.
struct SplineCell {
  std::size_t first;
  double tx, ty;

  SplineCell(const PlanLattice& lattice, double x, double y) {
    const double u = std::clamp((x - lattice.x0) * lattice.per_metre, 1.0, lattice.nx - 2.001);
    const double v = std::clamp((y - lattice.y0) * lattice.per_metre, 1.0, lattice.ny - 2.001);
    const int i = static_cast<int>(u);
    const int j = static_cast<int>(v);
    tx = u - i;
    ty = v - j;
    first = lattice.index(i - 1, j - 1);
  }
};

/// A scalar field in plan.
struct PlanField {
  PlanLattice lattice;
  std::vector<float> values;

  explicit PlanField(const PlanLattice& on = {}) : lattice(on), values(on.size(), 0.0f) {}
  float& at(int i, int j) { return values[lattice.index(i, j)]; }
  float at(int i, int j) const { return values[lattice.index(i, j)]; }

  double value(double x, double y) const {
    double dx, dy;
    return value(x, y, dx, dy);
  }
  /// In double precision, with the derivatives along x and y.
  double value(double x, double y, double& dx, double& dy) const {
    const SplineCell cell(lattice, x, y);
    const CubicWeights<double> wx(cell.tx), wy(cell.ty);
    const float* row = values.data() + cell.first;
    double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
    for (std::size_t j = 0; j < 4; ++j, row += lattice.nx) {
      const double c0 = row[0], c1 = row[1], c2 = row[2], c3 = row[3];
      const double v = (wx.w[0] * c0 + wx.w[1] * c1) + (wx.w[2] * c2 + wx.w[3] * c3);
      const double g = (wx.d[0] * c0 + wx.d[1] * c1) + (wx.d[2] * c2 + wx.d[3] * c3);
      sum += wy.w[j] * v;
      sum_x += wy.w[j] * g;
      sum_y += wy.d[j] * v;
    }
    dx = sum_x * lattice.per_metre;
    dy = sum_y * lattice.per_metre;
    return sum;
  }
};

}  // namespace cornice::simulate
