// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_field.h"

#include <cstring>

#include "core/base/random.h"

namespace cornice::simulate {
namespace {

/// Four floats in one register; the attribute is understood by g++ and clang alike.
typedef float Float4 __attribute__((vector_size(16)));

Float4 load4(const float* from) {
  Float4 value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
Float4 spread(float value) { return Float4{value, value, value, value}; }
float sum4(Float4 v) { return (v[0] + v[1]) + (v[2] + v[3]); }
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

struct RockSample {
  Float4 value, dx, dy;  // out_x, out_y, roughness, beds
};

RockSample sample_rock(const PlanLattice& lattice, const std::vector<RockNode>& nodes, double x,
                       double y) {
  const SplineCell cell(lattice, x, y);
  const CubicWeights<float> wx(static_cast<float>(cell.tx)), wy(static_cast<float>(cell.ty));
  const RockNode* row = nodes.data() + cell.first;
  RockSample sample{};
  for (std::size_t j = 0; j < 4; ++j, row += lattice.nx) {
    Float4 v{}, g{};
    for (std::size_t i = 0; i < 4; ++i) {
      const Float4 node = load4(&row[i].out_x);
      v += spread(wx.w[i]) * node;
      g += spread(wx.d[i]) * node;
    }
    sample.value += spread(wy.w[j]) * v;
    sample.dx += spread(wy.w[j]) * g;
    sample.dy += spread(wy.d[j]) * v;
  }
  const Float4 inverse = spread(static_cast<float>(1.0 / lattice.step));
  sample.dx *= inverse;
  sample.dy *= inverse;
  return sample;
}

}  // namespace

RoughnessVolume::RoughnessVolume(std::uint64_t seed) {
  // The spline leaves 0.479 of the variance of white noise per axis, 0.110 in space.
  constexpr float kGain = 3.016f;
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

float RoughnessVolume::value(Vec3d p, Vec3f& gradient) const {
  // Turned out of the axes, so that its period shows nowhere along them.
  constexpr double kScale = 1.0 / static_cast<double>(kStep);
  constexpr double c = 0.8, s = 0.6;
  const double u[3] = {(c * p.x - s * p.y) * kScale, (s * p.x + c * p.y) * kScale, p.z * kScale};
  int cell[3];
  float t[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double floor = std::floor(u[axis]);
    t[axis] = static_cast<float>(u[axis] - floor);
    cell[axis] = static_cast<int>(static_cast<std::int64_t>(floor) & (kSide - 1));
  }
  const CubicWeights<float> wx(t[0]), wy(t[1]), wz(t[2]);
  const float* slice =
      values_.data() + (static_cast<std::size_t>(cell[2]) * kPadded + cell[1]) * kPadded + cell[0];
  Float4 value{}, dy{}, dz{};
  for (std::size_t k = 0; k < 4; ++k, slice += kPadded * kPadded) {
    const float* row = slice;
    Float4 v{}, g{};
    for (std::size_t j = 0; j < 4; ++j, row += kPadded) {
      const Float4 four = load4(row);
      v += spread(wy.w[j]) * four;
      g += spread(wy.d[j]) * four;
    }
    value += spread(wz.w[k]) * v;
    dz += spread(wz.d[k]) * v;
    dy += spread(wz.w[k]) * g;
  }
  const float gx = sum4(as4(wx.d) * value) / kStep;
  const float gy = sum4(as4(wx.w) * dy) / kStep;
  gradient.x = static_cast<float>(c) * gx + static_cast<float>(s) * gy;
  gradient.y = static_cast<float>(-s) * gx + static_cast<float>(c) * gy;
  gradient.z = sum4(as4(wx.w) * dz) / kStep;
  return sum4(as4(wx.w) * value);
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
  const double floor = std::floor(u);
  const CubicWeights<float> weights(static_cast<float>(u - floor));
  const float* four =
      values_.data() + static_cast<std::size_t>(static_cast<std::int64_t>(floor) & (kCount - 1));
  const Float4 nodes = load4(four);
  derivative = sum4(as4(weights.d) * nodes) * inverse_step_;
  return sum4(as4(weights.w) * nodes);
}

void GroundField::add_lean(const Lean& lean, Vec3d p, double& wx, double& wy,
                           double (&jacobian)[2][3]) const {
  const double x = p.x - lean.x, y = p.y - lean.y;
  const double across = x * lean.out_x + y * lean.out_y;
  const double along = -x * lean.out_y + y * lean.out_x;
  double d_across, d_along, d_up;
  const double m_across = plateau(across, lean.half_depth, lean.fade, d_across);
  const double m_along = plateau(along, lean.half_length, lean.fade, d_along);
  const double rise = lean.top - lean.foot;
  const double up = smoother_step((p.z - lean.foot) / rise, d_up);
  const double moved = lean.reach * m_across * m_along * up;
  wx += lean.out_x * moved;
  wy += lean.out_y * moved;
  const double ga = lean.reach * up * d_across * m_along;
  const double gl = lean.reach * up * m_across * d_along;
  const double g[3] = {ga * lean.out_x - gl * lean.out_y, ga * lean.out_y + gl * lean.out_x,
                       lean.reach * m_across * m_along * d_up / rise};
  for (int axis = 0; axis < 3; ++axis) {
    jacobian[0][axis] += lean.out_x * g[axis];
    jacobian[1][axis] += lean.out_y * g[axis];
  }
}

double GroundField::cut_void(const Void& hole, Vec3d p, double value, double rough,
                             Vec3d rough_gradient, Vec3d* gradient) const {
  if (!hole.box.contains(p)) return value;
  const Vec3d r = p - hole.from;
  const double along = r.x * hole.axis.x + r.y * hole.axis.y;
  const double side = -r.x * hole.axis.y + r.y * hole.axis.x;
  const double over = along - std::clamp(along, 0.0, hole.length);
  const double size = std::min(hole.half_width, hole.half_height);
  const double iw = 1.0 / (hole.half_width * hole.half_width);
  const double ih = 1.0 / (hole.half_height * hole.half_height);
  const double rho2 = (side * side + over * over) * iw + r.z * r.z * ih;
  // Half of size (1 - rho^2) is near the distance at the wall of the void and smooth inside it.
  const double inside = 0.5 * size * (1.0 - rho2) + rough;
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
        rough_gradient;
    *gradient = *gradient * weight + g_inside * ((1.0 - weight) * hole.steepness);
  }
  return result * hole.steepness;
}

template <bool kWithGradient>
double GroundField::evaluate(Vec3d p, Vec3d* gradient) const {
  const RockSample rock_here = sample_rock(rock_lattice, rock, p.x, p.y);
  const double out_x = static_cast<double>(rock_here.value[0]);
  const double out_y = static_cast<double>(rock_here.value[1]);
  const double amplitude = static_cast<double>(rock_here.value[2]);
  const double bed_depth = static_cast<double>(rock_here.value[3]);

  Vec3f rough_slope;
  const double rough = static_cast<double>(roughness.value(p, rough_slope));
  const Vec3d r_grad = rough_slope.cast<double>();
  double bed = 0.0, bed_slope = 0.0;
  if (bed_depth != 0.0) {
    float derivative;
    bed = static_cast<double>(beds.value(p.z + dip_x * p.x + dip_y * p.y, derivative));
    bed_slope = static_cast<double>(derivative);
  }
  const double ar = amplitude * rough;
  const double g = bed_depth * bed + ar;
  double wx = out_x * g;
  double wy = out_y * g;

  // jacobian[i][axis] = d w_i / d axis
  double jacobian[2][3] = {};
  Vec3d ar_grad;
  if constexpr (kWithGradient) {
    ar_grad = Vec3d{static_cast<double>(rock_here.dx[2]) * rough + amplitude * r_grad.x,
                    static_cast<double>(rock_here.dy[2]) * rough + amplitude * r_grad.y,
                    amplitude * r_grad.z};
    const double slope = bed_depth * bed_slope;
    const double g_grad[3] = {
        static_cast<double>(rock_here.dx[3]) * bed + slope * dip_x + ar_grad.x,
        static_cast<double>(rock_here.dy[3]) * bed + slope * dip_y + ar_grad.y, slope + ar_grad.z};
    for (int i = 0; i < 2; ++i) {
      const double out = i == 0 ? out_x : out_y;
      jacobian[i][0] = static_cast<double>(rock_here.dx[i]) * g + out * g_grad[0];
      jacobian[i][1] = static_cast<double>(rock_here.dy[i]) * g + out * g_grad[1];
      jacobian[i][2] = out * g_grad[2];
    }
  }
  const std::vector<Feature>* features = features_at(p.x, p.y);
  if (features != nullptr) {
    for (const Feature feature : *features) {
      if (!feature.is_void && leans[feature.index].box.contains(p.x, p.y)) {
        add_lean(leans[feature.index], p, wx, wy, jacobian);
      }
    }
  }
  double hx, hy;
  const double h = height.value(p.x - wx, p.y - wy, hx, hy);
  double value = p.z - ar - h;
  if constexpr (kWithGradient) {
    *gradient = {-ar_grad.x - hx * (1.0 - jacobian[0][0]) + hy * jacobian[1][0],
                 -ar_grad.y + hx * jacobian[0][1] - hy * (1.0 - jacobian[1][1]),
                 1.0 - ar_grad.z + hx * jacobian[0][2] + hy * jacobian[1][2]};
  }
  if (features != nullptr) {
    for (const Feature feature : *features) {
      if (feature.is_void) {
        value = cut_void(voids[feature.index], p, value, ar, ar_grad,
                         kWithGradient ? gradient : nullptr);
      }
    }
  }
  return value;
}

template double GroundField::evaluate<false>(Vec3d p, Vec3d* gradient) const;
template double GroundField::evaluate<true>(Vec3d p, Vec3d* gradient) const;

void GroundField::index_features() {
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
