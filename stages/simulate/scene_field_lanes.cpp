// SPDX-License-Identifier: GPL-3.0-or-later
// The function of scene_field.cpp at four places at once, lane by lane in the same arithmetic.
#include <algorithm>
#include <cmath>

#include "stages/simulate/scene_field.h"
#include "stages/simulate/scene_lanes.h"

namespace cornice::simulate {
namespace {

/// QuadraticWeights of four places.
struct Quadratic4 {
  Float4 w[3], d[3];

  explicit Quadratic4(Float4 t) {
    const Float4 one = spread(1.0f), half = spread(0.5f);
    const Float4 s = one - t;
    w[0] = half * s * s, w[1] = half + t * s, w[2] = half * t * t;
    d[0] = -s, d[1] = one - spread(2.0f) * t, d[2] = t;
  }
};

/// CubicWeights of four places.
struct Cubic4 {
  Float4 w[4], d[4];

  explicit Cubic4(Float4 t) {
    const Float4 sixth = spread(1.0f / 6.0f), half = spread(0.5f), two = spread(2.0f);
    const Float4 three = spread(3.0f), four = spread(4.0f), three_halves = spread(1.5f);
    const Float4 s = spread(1.0f) - t;
    const Float4 t2 = t * t, s2 = s * s;
    w[0] = s2 * s * sixth, w[1] = (four + three * t2 * (t - two)) * sixth;
    w[2] = (four + three * s2 * (s - two)) * sixth, w[3] = t2 * t * sixth;
    d[0] = -(s2 * half), d[1] = t * (three_halves * t - two);
    d[2] = s * (two - three_halves * s), d[3] = t2 * half;
  }
};

struct Rock4 {
  Float4 value[4], dx[4], dy[4];  // out_x, out_y, roughness, beds
};

/// Node of a lattice below each of four coordinates, and the rest of the way in steps.
Float4 split(Double4 u, Int4& node) {
  node = __builtin_convertvector(u, Int4);
  return to_float(u - to_double(node));
}

template <bool kWithGradient>
void sample_rock(const PlanLattice& lattice, const std::vector<RockNode>& nodes, Double4 x,
                 Double4 y, Rock4& rock) {
  Int4 i, j;
  const Quadratic4 wx(split((x - lattice.x0) * lattice.per_metre + 0.5, i));
  const Quadratic4 wy(split((y - lattice.y0) * lattice.per_metre + 0.5, j));
  Lanes lanes;
  for (int n = 0; n < 4; ++n) lanes.from[n] = &nodes[lattice.index(i[n] - 1, j[n] - 1)].out_x;
  rock = {};
  for (int k = 0; k < 3; ++k) {
    Float4 node[3][4];
    const std::size_t row = static_cast<std::size_t>(k) * static_cast<std::size_t>(lattice.nx) * 4;
    for (std::size_t c = 0; c < 3; ++c) lanes.load(row + 4 * c, node[c]);
    for (int f = 0; f < 4; ++f) {
      const Float4 value = wx.w[0] * node[0][f] + wx.w[1] * node[1][f] + wx.w[2] * node[2][f];
      rock.value[f] += wy.w[k] * value;
      if constexpr (kWithGradient) {
        const Float4 slope = wx.d[0] * node[0][f] + wx.d[1] * node[1][f] + wx.d[2] * node[2][f];
        rock.dx[f] += wy.w[k] * slope;
        rock.dy[f] += wy.d[k] * value;
      }
    }
  }
  if constexpr (kWithGradient) {
    const Float4 per_metre = spread(static_cast<float>(lattice.per_metre));
    for (int f = 0; f < 4; ++f) rock.dx[f] *= per_metre, rock.dy[f] *= per_metre;
  }
}

template <bool kWithGradient>
Double4 spline_height(const PlanField& field, Double4 x, Double4 y, Double4& dx, Double4& dy) {
  const PlanLattice& lattice = field.lattice;
  Int4 i, j;
  const Cubic4 wx(split((x - lattice.x0) * lattice.per_metre, i));
  const Cubic4 wy(split((y - lattice.y0) * lattice.per_metre, j));
  const auto stride = static_cast<std::size_t>(lattice.nx);
  Lanes lanes;
  Float4 reference{};
  for (int n = 0; n < 4; ++n) {
    lanes.from[n] = field.values.data() + lattice.index(i[n] - 1, j[n] - 1);
    reference[n] = lanes.from[n][stride + 1];
  }
  Float4 value[4] = {}, slope[4] = {};
  for (std::size_t k = 0; k < 4; ++k) {
    Float4 row[4];
    lanes.load(k * stride, row);
    for (int c = 0; c < 4; ++c) {
      const Float4 v = row[c] - reference;
      value[c] += wy.w[k] * v;
      if constexpr (kWithGradient) slope[c] += wy.d[k] * v;
    }
  }
  const auto across = [](const Float4(&w)[4], const Float4(&v)[4]) {
    return (w[0] * v[0] + w[1] * v[1]) + (w[2] * v[2] + w[3] * v[3]);
  };
  if constexpr (kWithGradient) {
    dx = to_double(across(wx.d, value)) * lattice.per_metre;
    dy = to_double(across(wx.w, slope)) * lattice.per_metre;
  }
  return to_double(reference) + to_double(across(wx.w, value));
}

/// Heights beyond are no ground; floor4() has its limit.
constexpr double kHighest = 1e5;

}  // namespace

/// What is private to the parts of the field, four places at once.
struct FieldLanes {
  template <bool kWithGradient>
  static Float4 value(const RoughnessVolume& roughness, Double4 x, Double4 y, Double4 z,
                      Float4 (&gradient)[3]);
  static Float4 value(const BedProfile& beds, Double4 height, Float4& derivative);
};

template <bool kWithGradient>
Float4 FieldLanes::value(const RoughnessVolume& roughness, Double4 x, Double4 y, Double4 z,
                         Float4 (&gradient)[3]) {
  constexpr int kPadded = RoughnessVolume::kPadded;
  constexpr float kStep = RoughnessVolume::kStep;
  constexpr double kScale = 1.0 / (3.0 * static_cast<double>(kStep));
  const Double4 u[3] = {(2.0 * x - 2.0 * y + z) * kScale, (2.0 * x + y - 2.0 * z) * kScale,
                        (x + 2.0 * y + 2.0 * z) * kScale};
  Int4 cell[3];
  Float4 t[3];
  for (int axis = 0; axis < 3; ++axis) {
    const Int4 floor = floor4(u[axis]);
    t[axis] = to_float(u[axis] - to_double(floor));
    cell[axis] = floor & (RoughnessVolume::kSide - 1);
  }
  const Quadratic4 wx(t[0]), wy(t[1]), wz(t[2]);
  const Int4 first = (cell[2] * kPadded + cell[1]) * kPadded + cell[0];
  Lanes lanes;
  for (int n = 0; n < 4; ++n) lanes.from[n] = roughness.values_.data() + first[n];
  Float4 value[3] = {}, dy[3] = {}, dz[3] = {};
  for (std::size_t k = 0; k < 3; ++k) {
    Float4 row[3][4];
    for (std::size_t j = 0; j < 3; ++j) lanes.load((k * kPadded + j) * kPadded, row[j]);
    for (int c = 0; c < 3; ++c) {
      const Float4 v = wy.w[0] * row[0][c] + wy.w[1] * row[1][c] + wy.w[2] * row[2][c];
      value[c] += wz.w[k] * v;
      if constexpr (kWithGradient) {
        dz[c] += wz.d[k] * v;
        dy[c] += wz.w[k] * (wy.d[0] * row[0][c] + wy.d[1] * row[1][c] + wy.d[2] * row[2][c]);
      }
    }
  }
  const auto across = [](const Float4(&w)[3], const Float4(&v)[3]) {
    return w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
  };
  if constexpr (kWithGradient) {
    const Float4 slope = spread(1.0f / (3.0f * kStep)), two = spread(2.0f);
    const Float4 a = across(wx.d, value) * slope;
    const Float4 b = across(wx.w, dy) * slope;
    const Float4 c = across(wx.w, dz) * slope;
    gradient[0] = two * a + two * b + c;
    gradient[1] = b + two * c - two * a;
    gradient[2] = a - two * b + two * c;
  }
  return across(wx.w, value);
}

Float4 FieldLanes::value(const BedProfile& beds, Double4 height, Float4& derivative) {
  const Double4 u = height * static_cast<double>(beds.inverse_step_);
  const Int4 floor = floor4(u);
  const Cubic4 weights(to_float(u - to_double(floor)));
  Lanes lanes;
  for (int n = 0; n < 4; ++n)
    lanes.from[n] = beds.values_.data() + (floor[n] & (BedProfile::kCount - 1));
  Float4 v[4];
  lanes.load(0, v);
  const auto across = [&](const Float4(&w)[4]) {
    return (w[0] * v[0] + w[1] * v[1]) + (w[2] * v[2] + w[3] * v[3]);
  };
  derivative = across(weights.d) * beds.inverse_step_;
  return across(weights.w);
}

template <bool kWithGradient>
void GroundField::evaluate4(const Vec3d* p, double* values, Vec3d* gradients) const {
  const Double4 x{p[0].x, p[1].x, p[2].x, p[3].x}, y{p[0].y, p[1].y, p[2].y, p[3].y};
  const Double4 z{p[0].z, p[1].z, p[2].z, p[3].z};
  Rock4 here;
  sample_rock<kWithGradient>(rock_lattice, rock, x, y, here);
  const Double4 out_x = to_double(here.value[0]), out_y = to_double(here.value[1]);
  const Double4 amplitude = to_double(here.value[2]), bed_depth = to_double(here.value[3]);
  Float4 rough_slope[3];
  const Double4 rough =
      to_double(FieldLanes::value<kWithGradient>(roughness, x, y, z, rough_slope));
  Float4 bed_derivative;
  const Double4 bed = to_double(FieldLanes::value(beds, z + dip_x * x + dip_y * y, bed_derivative));
  const Double4 ar = amplitude * rough;
  const Double4 g = bed_depth * bed + ar;
  Double4 hx{}, hy{};
  const Double4 h = spline_height<kWithGradient>(height, x - out_x * g, y - out_y * g, hx, hy);
  const Double4 value = z - ar - h;
  std::memcpy(values, &value, sizeof value);
  if constexpr (kWithGradient) {
    // As in evaluate(): first by the place looked up, then by the point itself, then together.
    const Double4 s = hx * out_x + hy * out_y;
    const auto by_place = [&](Double4 slope, const Float4(&d)[4]) {
      return g * (hx * to_double(d[0]) + hy * to_double(d[1])) - slope - to_double(d[2]) * rough +
             s * (to_double(d[3]) * bed + to_double(d[2]) * rough);
    };
    const Double4 k = (s - 1.0) * amplitude;
    const Double4 sb = s * bed_depth * to_double(bed_derivative);
    const Double4 gx = by_place(hx, here.dx) + k * to_double(rough_slope[0]) + sb * dip_x;
    const Double4 gy = by_place(hy, here.dy) + k * to_double(rough_slope[1]) + sb * dip_y;
    const Double4 gz = 1.0 + k * to_double(rough_slope[2]) + sb;
    for (int n = 0; n < 4; ++n) gradients[n] = {gx[n], gy[n], gz[n]};
  }
}

template <bool kWithGradient>
void GroundField::evaluate_all(const Vec3d* places, std::size_t count, double* values,
                               Vec3d* gradients) const {
  for (std::size_t first = 0; first < count; first += 4) {
    const std::size_t lanes = std::min<std::size_t>(4, count - first);
    Vec3d p[4], g[4];
    double v[4];
    bool is_usual[4];
    for (std::size_t n = 0; n < 4; ++n) {
      p[n] = places[first + std::min(n, lanes - 1)];
      // Leans, voids and the borders of the lattices are looked at one by one.
      is_usual[n] = inner_.contains(p[n].x, p[n].y) && std::abs(p[n].z) < kHighest &&
                    features_at(p[n].x, p[n].y) == nullptr;
    }
    // One lane that is not usual stands in for none: any place that is will do.
    const std::size_t usual =
        static_cast<std::size_t>(std::find(is_usual, is_usual + 4, true) - is_usual);
    Vec3d q[4];
    for (std::size_t n = 0; n < 4 && usual < 4; ++n) q[n] = p[is_usual[n] ? n : usual];
    if (usual < 4) evaluate4<kWithGradient>(q, v, g);
    for (std::size_t n = 0; n < lanes; ++n) {
      if (!is_usual[n]) v[n] = evaluate<kWithGradient>(p[n], &g[n]);
      values[first + n] = v[n];
      if constexpr (kWithGradient) gradients[first + n] = g[n];
    }
  }
}

void GroundField::values(const Vec3d* places, std::size_t count, double* values) const {
  evaluate_all<false>(places, count, values, nullptr);
}

void GroundField::values(const Vec3d* places, std::size_t count, double* values,
                         Vec3d* gradients) const {
  evaluate_all<true>(places, count, values, gradients);
}

}  // namespace cornice::simulate
