// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_field.h"

#include <cstring>

#include "core/base/random.h"
#include "stages/simulate/scene_lanes.h"

namespace cornice::simulate {
namespace {

float sum4(Float4 v) { return (v[0] + v[1]) + (v[2] + v[3]); }
float sum3(const std::array<float, 3>& w, Float4 v) {
  return w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
}
Float4 as4(const std::array<float, 4>& w) { return Float4{w[0], w[1], w[2], w[3]}; }

/// 0 below 0, 1 above 1, C2 between (Perlin 2002), with its derivative.
double smoother_step(double t, double& derivative) {
  if (t <= 0.0 || t >= 1.0) {
    derivative = 0.0;
    return t <= 0.0 ? 0.0 : 1.0;
  }
  derivative = 30.0 * t * t * (t - 1.0) * (t - 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

/// 1 for |u| < half, 0 beyond half + fade, smooth between.
double plateau(double u, double half, double fade, double& derivative) {
  const double value = smoother_step((half + fade - std::abs(u)) / fade, derivative);
  derivative *= (u < 0.0 ? 1.0 : -1.0) / fade;
  return value;
}

/// The cubic spline of heights as in PlanField, in single precision relative to one of its nodes:
/// off by some 1e-7 of the height that the neighbourhood spans.
template <bool kWithGradient>
double spline_height(const PlanField& field, double x, double y, double& dx, double& dy) {
  const SplineCell cell(field.lattice, x, y);
  const CubicWeights<float> wx(static_cast<float>(cell.tx)), wy(static_cast<float>(cell.ty));
  const float* row = field.values.data() + cell.first;
  const std::size_t stride = static_cast<std::size_t>(field.lattice.nx);
  const float reference = row[stride + 1];
  const Float4 base = spread(reference);
  const Float4 r0 = load4(row) - base, r1 = load4(row + stride) - base;
  const Float4 r2 = load4(row + 2 * stride) - base, r3 = load4(row + 3 * stride) - base;
  const Float4 value =
      (spread(wy.w[0]) * r0 + spread(wy.w[1]) * r1) + (spread(wy.w[2]) * r2 + spread(wy.w[3]) * r3);
  if constexpr (kWithGradient) {
    const Float4 slope = (spread(wy.d[0]) * r0 + spread(wy.d[1]) * r1) +
                         (spread(wy.d[2]) * r2 + spread(wy.d[3]) * r3);
    dx = static_cast<double>(sum4(as4(wx.d) * value)) * field.lattice.per_metre;
    dy = static_cast<double>(sum4(as4(wx.w) * slope)) * field.lattice.per_metre;
  }
  return static_cast<double>(reference) + static_cast<double>(sum4(as4(wx.w) * value));
}

struct RockSample {
  Float4 value, dx, dy;  // out_x, out_y, roughness, beds
};

template <bool kWithGradient>
RockSample sample_rock(const PlanLattice& lattice, const std::vector<RockNode>& nodes, double x,
                       double y) {
  const double u = std::clamp((x - lattice.x0) * lattice.per_metre + 0.5, 1.0, lattice.nx - 1.001);
  const double v = std::clamp((y - lattice.y0) * lattice.per_metre + 0.5, 1.0, lattice.ny - 1.001);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const QuadraticWeights wx(static_cast<float>(u - i)), wy(static_cast<float>(v - j));
  const RockNode* row = nodes.data() + lattice.index(i - 1, j - 1);
  RockSample sample{};
  for (std::size_t k = 0; k < 3; ++k, row += lattice.nx) {
    const Float4 n0 = load4(&row[0].out_x), n1 = load4(&row[1].out_x), n2 = load4(&row[2].out_x);
    const Float4 value = spread(wx.w[0]) * n0 + spread(wx.w[1]) * n1 + spread(wx.w[2]) * n2;
    sample.value += spread(wy.w[k]) * value;
    if constexpr (kWithGradient) {
      const Float4 slope = spread(wx.d[0]) * n0 + spread(wx.d[1]) * n1 + spread(wx.d[2]) * n2;
      sample.dx += spread(wy.w[k]) * slope;
      sample.dy += spread(wy.d[k]) * value;
    }
  }
  if constexpr (kWithGradient) {
    const Float4 per_metre = spread(static_cast<float>(lattice.per_metre));
    sample.dx *= per_metre;
    sample.dy *= per_metre;
  }
  return sample;
}

}  // namespace

RoughnessVolume::RoughnessVolume(std::uint64_t seed) {
  // The spline leaves 11/20 of the variance of white noise per axis.
  constexpr float kGain = 2.4517f;
  values_.resize(static_cast<std::size_t>(kPadded) * kPadded * kPadded);
  std::size_t at = 0;
  for (int k = 0; k < kPadded; ++k) {
    for (int j = 0; j < kPadded; ++j) {
      for (int i = 0; i < kPadded; ++i) {
        const int item = (k % kSide * kSide + j % kSide) * kSide + i % kSide;
        CounterRandom random(seed, 71, static_cast<std::uint64_t>(item));
        // Triangular rather than normal, so that there is a limit.
        const double white = (random.uniform() - random.uniform()) * std::sqrt(6.0);
        values_[at++] = kGain * static_cast<float>(white);
      }
    }
  }
}

template <bool kWithGradient>
float RoughnessVolume::value(Vec3d p, Vec3f& gradient) const {
  // Rows of a rotation (2/3, 2/3, 1/3; ...) by the Pythagorean quadruple 1, 2, 2, 3.
  constexpr double kScale = 1.0 / (3.0 * static_cast<double>(kStep));
  const double u[3] = {(2.0 * p.x - 2.0 * p.y + p.z) * kScale,
                       (2.0 * p.x + p.y - 2.0 * p.z) * kScale,
                       (p.x + 2.0 * p.y + 2.0 * p.z) * kScale};
  std::size_t cell[3];
  float t[3];
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t floor = floor_of(u[axis]);
    t[axis] = static_cast<float>(u[axis] - static_cast<double>(floor));
    cell[axis] = static_cast<std::size_t>(floor & (kSide - 1));
  }
  const QuadraticWeights wx(t[0]), wy(t[1]), wz(t[2]);
  const float* slice = values_.data() + (cell[2] * kPadded + cell[1]) * kPadded + cell[0];
  // The fourth lane is read and weighted by zero.
  Float4 value{}, dy{}, dz{};
  for (std::size_t k = 0; k < 3; ++k, slice += kPadded * kPadded) {
    const Float4 r0 = load4(slice), r1 = load4(slice + kPadded), r2 = load4(slice + 2 * kPadded);
    const Float4 v = spread(wy.w[0]) * r0 + spread(wy.w[1]) * r1 + spread(wy.w[2]) * r2;
    value += spread(wz.w[k]) * v;
    if constexpr (kWithGradient) {
      dz += spread(wz.d[k]) * v;
      dy += spread(wz.w[k]) * (spread(wy.d[0]) * r0 + spread(wy.d[1]) * r1 + spread(wy.d[2]) * r2);
    }
  }
  if constexpr (kWithGradient) {
    constexpr float kSlope = 1.0f / (3.0f * kStep);
    const float a = sum3(wx.d, value) * kSlope;
    const float b = sum3(wx.w, dy) * kSlope;
    const float c = sum3(wx.w, dz) * kSlope;
    gradient = {2.0f * a + 2.0f * b + c, -2.0f * a + b + 2.0f * c, a - 2.0f * b + 2.0f * c};
  }
  return sum3(wx.w, value);
}

BedProfile::BedProfile(double thickness_m, std::uint64_t seed)
    : inverse_step_(static_cast<float>(4.0 / thickness_m)), values_(kCount + 3) {
  // Beds of random thickness, each with its own hardness; four nodes in a mean bed.
  double hardness = 0.0;
  int left = 0;
  std::uint64_t bed = 0;
  for (int i = 0; i < kCount; ++i) {
    if (left-- == 0) {
      CounterRandom random(seed, 72, bed++);
      left = 1 + static_cast<int>(random.uniform() * random.uniform() * 12.0);
      hardness = random.uniform(-1.0, 1.0);
      hardness = std::copysign(std::sqrt(std::abs(hardness)), hardness);
    }
    values_[static_cast<std::size_t>(i)] = static_cast<float>(hardness);
  }
  std::copy_n(values_.begin(), 3, values_.begin() + kCount);
}

float BedProfile::value(double height, float& derivative) const {
  const double u = height * static_cast<double>(inverse_step_);
  const std::int64_t floor = floor_of(u);
  const CubicWeights<float> weights(static_cast<float>(u - static_cast<double>(floor)));
  const float* four = values_.data() + static_cast<std::size_t>(floor & (kCount - 1));
  const Float4 nodes = load4(four);
  derivative = sum4(as4(weights.d) * nodes) * inverse_step_;
  return sum4(as4(weights.w) * nodes);
}

Vec2d GroundField::lean_back(const std::vector<Feature>& features, Vec3d p,
                             double (&jacobian)[2][3]) const {
  Vec2d q{p.x, p.y};
  for (const Feature feature : features) {
    if (feature.is_void || !leans[feature.index].box.contains(p.x, p.y)) continue;
    const Lean& lean = leans[feature.index];
    if (p.z <= lean.foot) continue;
    const double x = p.x - lean.x, y = p.y - lean.y;
    const double across = x * lean.out_x + y * lean.out_y;
    const double along = -x * lean.out_y + y * lean.out_x;
    double d_across, d_along, d_up;
    const double m_across = plateau(across, lean.half_depth, lean.fade, d_across);
    const double m_along = plateau(along, lean.half_length, lean.fade, d_along);
    const double rise = lean.top - lean.foot;
    const double up = smoother_step((p.z - lean.foot) / rise, d_up);
    const double moved = lean.reach * m_across * m_along * up;
    q.x -= lean.out_x * moved;
    q.y -= lean.out_y * moved;
    const double ga = lean.reach * up * d_across * m_along;
    const double gl = lean.reach * up * m_across * d_along;
    const double g[3] = {ga * lean.out_x - gl * lean.out_y, ga * lean.out_y + gl * lean.out_x,
                         lean.reach * m_across * m_along * d_up / rise};
    for (int axis = 0; axis < 3; ++axis) {
      jacobian[0][axis] += lean.out_x * g[axis];
      jacobian[1][axis] += lean.out_y * g[axis];
    }
  }
  return q;
}

double GroundField::cut_void(const Void& hole, Vec3d p, double value, Vec3d* gradient) const {
  if (!hole.box.contains(p)) return value;
  const Vec3d r = p - hole.from;
  const double along = r.x * hole.axis.x + r.y * hole.axis.y;
  const double side = -r.x * hole.axis.y + r.y * hole.axis.x;
  const double over = along - std::clamp(along, 0.0, hole.length);
  const double size = std::min(hole.half_width, hole.half_height);
  const double iw = 1.0 / (hole.half_width * hole.half_width);
  const double ih = 1.0 / (hole.half_height * hole.half_height);
  const double rho2 = (side * side + over * over) * iw + r.z * r.z * ih;
  if (rho2 > 4.0) return value;
  // The walls wave by a seventh of the size, in waves of two steps of roughness times kStretch.
  constexpr double kStretch = 4.0;
  Vec3f wave_slope;
  const double depth = 0.07 * size;
  const double wave =
      depth * static_cast<double>(roughness.value<true>(p * (1.0 / kStretch), wave_slope));
  // Half of size (1 - rho^2) is near the distance at the wall of the void and smooth inside it.
  const double inside = 0.5 * size * (1.0 - rho2) + wave;
  const double scaled = value / hole.steepness;
  const double h = std::max(hole.blend - std::abs(scaled - inside), 0.0) / hole.blend;
  if (scaled > inside && h == 0.0) return value;
  // Smooth maximum, C2 (Quilez, the cubic polynomial form).
  const double result = std::max(scaled, inside) + h * h * h * hole.blend / 6.0;
  if (gradient != nullptr) {
    const double weight = scaled > inside ? 1.0 - 0.5 * h * h : 0.5 * h * h;
    const Vec3d g_inside =
        Vec3d{-size * iw * (over * hole.axis.x - side * hole.axis.y),
              -size * iw * (over * hole.axis.y + side * hole.axis.x), -size * ih * r.z} +
        wave_slope.cast<double>() * (depth / kStretch);
    *gradient = *gradient * weight + g_inside * ((1.0 - weight) * hole.steepness);
  }
  return result * hole.steepness;
}

template <bool kWithGradient>
double GroundField::evaluate(Vec3d p, Vec3d* gradient) const {
  const std::vector<Feature>* features = features_at(p.x, p.y);
  double lean_jacobian[2][3] = {};
  Vec2d q{p.x, p.y};
  if (features != nullptr) q = lean_back(*features, p, lean_jacobian);

  const RockSample here = sample_rock<kWithGradient>(rock_lattice, rock, q.x, q.y);
  const double out_x = static_cast<double>(here.value[0]);
  const double out_y = static_cast<double>(here.value[1]);
  const double amplitude = static_cast<double>(here.value[2]);
  const double bed_depth = static_cast<double>(here.value[3]);
  Vec3f rough_slope;
  const double rough = static_cast<double>(roughness.value<kWithGradient>(p, rough_slope));
  double bed = 0.0, bed_slope = 0.0;
  if (bed_depth != 0.0) {
    float derivative;
    bed = static_cast<double>(beds.value(p.z + dip_x * p.x + dip_y * p.y, derivative));
    bed_slope = bed_depth * static_cast<double>(derivative);
  }
  const double ar = amplitude * rough;
  const double g = bed_depth * bed + ar;
  double hx = 0.0, hy = 0.0;
  const double h = spline_height<kWithGradient>(height, q.x - out_x * g, q.y - out_y * g, hx, hy);
  double value = p.z - ar - h;
  if constexpr (kWithGradient) {
    // First by q with p held, then by p with q held, then together.
    const auto d = [](const Float4& v, int n) { return static_cast<double>(v[n]); };
    const double s = hx * out_x + hy * out_y;
    const double by_qx = -hx - d(here.dx, 2) * rough +
                         g * (hx * d(here.dx, 0) + hy * d(here.dx, 1)) +
                         s * (d(here.dx, 3) * bed + d(here.dx, 2) * rough);
    const double by_qy = -hy - d(here.dy, 2) * rough +
                         g * (hx * d(here.dy, 0) + hy * d(here.dy, 1)) +
                         s * (d(here.dy, 3) * bed + d(here.dy, 2) * rough);
    const double k = (s - 1.0) * amplitude;
    const double sb = s * bed_slope;
    *gradient = {
        by_qx + k * static_cast<double>(rough_slope.x) + sb * dip_x,
        by_qy + k * static_cast<double>(rough_slope.y) + sb * dip_y,
        1.0 + k * static_cast<double>(rough_slope.z) + sb,
    };
    if (features != nullptr) {
      gradient->x -= lean_jacobian[0][0] * by_qx + lean_jacobian[1][0] * by_qy;
      gradient->y -= lean_jacobian[0][1] * by_qx + lean_jacobian[1][1] * by_qy;
      gradient->z -= lean_jacobian[0][2] * by_qx + lean_jacobian[1][2] * by_qy;
    }
  }
  if (features != nullptr) {
    for (const Feature feature : *features) {
      if (!feature.is_void) continue;
      value = cut_void(voids[feature.index], p, value, kWithGradient ? gradient : nullptr);
    }
  }
  return value;
}

template double GroundField::evaluate<false>(Vec3d p, Vec3d* gradient) const;
template double GroundField::evaluate<true>(Vec3d p, Vec3d* gradient) const;

void GroundField::prepare() {
  double reach = 0.0;
  for (const RockNode& node : rock)
    reach =
        std::max(reach, static_cast<double>(std::hypot(node.out_x, node.out_y) *
                                            (std::abs(node.roughness) * RoughnessVolume::kLimit +
                                             std::abs(node.beds))));
  const auto inside = [](const PlanLattice& lattice, double border) {
    const double steps = border + 3.0 * lattice.step;
    return Box2d{lattice.x0 + steps, lattice.y0 + steps, lattice.x(lattice.nx - 1) - steps,
                 lattice.y(lattice.ny - 1) - steps};
  };
  // Mixed nodes can reach further than each alone; twice is more than enough.
  const Box2d a = inside(rock_lattice, 0.0), b = inside(height.lattice, 2.0 * reach);
  inner_ = {std::max(a.min_x, b.min_x), std::max(a.min_y, b.min_y), std::min(a.max_x, b.max_x),
            std::min(a.max_y, b.max_y)};
  features_.clear();
  feature_area_ = {};
  for (const Lean& lean : leans) {
    feature_area_.add(lean.box.min_x, lean.box.min_y);
    feature_area_.add(lean.box.max_x, lean.box.max_y);
  }
  for (const Void& hole : voids) {
    feature_area_.add(hole.box.min.x, hole.box.min.y);
    feature_area_.add(hole.box.max.x, hole.box.max.y);
  }
  if (feature_area_.empty()) return;
  feature_columns_ = static_cast<int>(feature_area_.width() / kFeatureCell) + 1;
  feature_rows_ = static_cast<int>(feature_area_.height() / kFeatureCell) + 1;
  features_.resize(static_cast<std::size_t>(feature_columns_) * feature_rows_);
  const auto put = [&](const Box2d& box, Feature feature) {
    const auto cell = [](double low, double v) {
      return static_cast<int>((v - low) / kFeatureCell);
    };
    for (int j = cell(feature_area_.min_y, box.min_y); j <= cell(feature_area_.min_y, box.max_y);
         ++j) {
      for (int i = cell(feature_area_.min_x, box.min_x); i <= cell(feature_area_.min_x, box.max_x);
           ++i) {
        features_[static_cast<std::size_t>(j) * feature_columns_ + i].push_back(feature);
      }
    }
  };
  for (std::size_t i = 0; i < leans.size(); ++i) {
    put(leans[i].box, {false, static_cast<std::uint16_t>(i)});
  }
  for (std::size_t i = 0; i < voids.size(); ++i) {
    put(voids[i].box.plan(), {true, static_cast<std::uint16_t>(i)});
  }
}

const std::vector<GroundField::Feature>* GroundField::features_at(double x, double y) const {
  if (features_.empty() || !feature_area_.contains(x, y)) return nullptr;
  const auto i = static_cast<std::size_t>((x - feature_area_.min_x) / kFeatureCell);
  const auto j = static_cast<std::size_t>((y - feature_area_.min_y) / kFeatureCell);
  const auto& list = features_[j * static_cast<std::size_t>(feature_columns_) + i];
  return list.empty() ? nullptr : &list;
}

GroundField::Range GroundField::height_range(const Box2d& box) const {
  double reach = 0.0, rough = 0.0;
  const auto nodes = [](const PlanLattice& lattice, const Box2d& over, auto&& visit) {
    const auto index = [&](double v, double low, int count) {
      return std::clamp(static_cast<int>(std::floor((v - low) / lattice.step)), 0, count - 1);
    };
    const int i1 = std::min(index(over.max_x, lattice.x0, lattice.nx) + 2, lattice.nx - 1);
    const int j1 = std::min(index(over.max_y, lattice.y0, lattice.ny) + 2, lattice.ny - 1);
    for (int j = std::max(index(over.min_y, lattice.y0, lattice.ny) - 1, 0); j <= j1; ++j) {
      for (int i = std::max(index(over.min_x, lattice.x0, lattice.nx) - 1, 0); i <= i1; ++i) {
        visit(lattice.index(i, j));
      }
    }
  };
  nodes(rock_lattice, box, [&](std::size_t at) {
    const double a = std::abs(static_cast<double>(rock[at].roughness)) *
                     static_cast<double>(RoughnessVolume::kLimit);
    rough = std::max(rough, a);
    reach = std::max(reach, a + std::abs(static_cast<double>(rock[at].beds)));
  });
  for (const Lean& lean : leans) {
    if (lean.box.intersects(box)) reach += lean.reach;
  }
  Range range{1e30, -1e30};
  nodes(height.lattice, box.grown(reach), [&](std::size_t at) {
    range.low = std::min(range.low, static_cast<double>(height.values[at]));
    range.high = std::max(range.high, static_cast<double>(height.values[at]));
  });
  range.low -= rough;
  range.high += rough;
  for (const Void& hole : voids) {
    if (!hole.box.plan().intersects(box)) continue;
    range.low = std::min(range.low, hole.box.min.z);
    range.high = std::max(range.high, hole.box.max.z);
  }
  return range;
}

}  // namespace cornice::simulate
