// SPDX-License-Identifier: GPL-3.0-or-later
// Drainage by priority flood (Barnes, Lehman, Mulla 2014); implicit stream power incision
// dh/dt = -K A^m |grad h| solved from the outlets upwards (Braun & Willett 2013, n = 1).
#include "stages/simulate/scene_erosion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

#include "core/base/random.h"
#include "stages/simulate/scene_noise.h"

namespace cornice::simulate {
namespace {

constexpr double kAreaExponent = 0.42;
constexpr int kSides[8][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};

double side_length(int side) { return side < 4 ? 1.0 : std::numbers::sqrt2; }

/// Every node after the one it drains to.
struct Drainage {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> receiver;  // itself at an outlet
  std::vector<float> length;            // to the receiver, in steps
  std::vector<double> area;             // nodes upstream, itself included
};

Drainage drain(const PlanField& ground) {
  const PlanLattice& lattice = ground.lattice;
  struct Entry {
    float level;
    std::uint32_t node;
    bool operator>(const Entry& o) const {
      return level != o.level ? level > o.level : node > o.node;
    }
  };
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const std::size_t count = lattice.size();
  Drainage d;
  d.order.reserve(count);
  d.receiver.resize(count);
  d.length.assign(count, 1.0f);
  std::vector<std::uint8_t> seen(count, 0), done(count, 0);
  std::vector<float> level(ground.values);
  const auto open = [&](int i, int j) {
    const auto n = static_cast<std::uint32_t>(lattice.index(i, j));
    if (seen[n]) return;
    seen[n] = 1;
    d.receiver[n] = n;
    queue.push({level[n], n});
  };
  for (int i = 0; i < lattice.nx; ++i) open(i, 0), open(i, lattice.ny - 1);
  for (int j = 0; j < lattice.ny; ++j) open(0, j), open(lattice.nx - 1, j);
  while (!queue.empty()) {
    const std::uint32_t n = queue.top().node;
    queue.pop();
    const int i = static_cast<int>(n) % lattice.nx, j = static_cast<int>(n) / lattice.nx;
    const bool border = i == 0 || j == 0 || i == lattice.nx - 1 || j == lattice.ny - 1;
    double steepest = 0.0;
    for (int side = 0; side < 8; ++side) {
      const int a = i + kSides[side][0], b = j + kSides[side][1];
      if (a < 0 || b < 0 || a >= lattice.nx || b >= lattice.ny) continue;
      const auto m = static_cast<std::uint32_t>(lattice.index(a, b));
      if (!seen[m]) {
        seen[m] = 1;
        level[m] = std::max(level[m], level[n] + 1e-4f);
        d.receiver[m] = n;
        d.length[m] = static_cast<float>(side_length(side));
        queue.push({level[m], m});
      } else if (done[m] && !border) {
        const double slope = static_cast<double>(level[n] - level[m]) / side_length(side);
        if (slope > steepest) {
          steepest = slope;
          d.receiver[n] = m;
          d.length[n] = static_cast<float>(side_length(side));
        }
      }
    }
    done[n] = 1;
    d.order.push_back(n);
  }
  d.area.assign(count, 1.0);
  for (std::size_t at = count; at-- > 0;) {
    const std::uint32_t n = d.order[at];
    if (d.receiver[n] != n) d.area[d.receiver[n]] += d.area[n];
  }
  return d;
}

/// Steepest slope that stands at a place, as a tangent: patches and belts of sound rock.
class RockHardness {
 public:
  RockHardness(const PlanLattice& lattice, const ErosionShape& erosion, std::uint64_t seed)
      : patch_(lattice.size()), erodibility_(lattice.size()), belt_(kBelts) {
    for (int j = 0; j < lattice.ny; ++j) {
      for (int i = 0; i < lattice.nx; ++i) {
        patch_[lattice.index(i, j)] = static_cast<float>(
            fractal_noise(lattice.x(i) / 210.0, lattice.y(j) / 210.0, 2, 0.5, seed + 11));
        CounterRandom random(seed, 14, lattice.index(i, j));
        erodibility_[lattice.index(i, j)] = static_cast<float>(random.uniform(0.15, 1.85));
      }
    }
    for (int n = 0; n < kBelts; ++n) {
      belt_[n] = static_cast<float>(0.8 * gradient_noise(n * kBeltStep / 95.0, 0.37, seed + 13));
    }
    soft_ = std::tan(erosion.soft_deg * std::numbers::pi / 180.0);
    hard_ = std::tan(erosion.hard_deg * std::numbers::pi / 180.0);
  }

  /// Uneven from node to node, or the lattice's eight directions show as straight gullies.
  double erodibility(std::size_t node) const { return static_cast<double>(erodibility_[node]); }

  double standing_slope(std::size_t node, double z) const {
    const double patch = static_cast<double>(patch_[node]);
    const auto n = static_cast<int>(z / kBeltStep + 9.0 * patch + 0.5 * kBelts);
    const double hard =
        smooth_step(-0.25, 0.45, patch + static_cast<double>(belt_[n & (kBelts - 1)]));
    return std::lerp(soft_, hard_, hard);
  }

 private:
  static constexpr int kBelts = 1 << 12;
  static constexpr double kBeltStep = 2.0;
  std::vector<float> patch_;
  std::vector<float> erodibility_;
  std::vector<float> belt_;  // by height
  double soft_, hard_;
};

void incise(PlanField& ground, const RockHardness& rock, double strength) {
  const PlanLattice& lattice = ground.lattice;
  const Drainage d = drain(ground);
  const double node_area = lattice.step * lattice.step;
  for (const std::uint32_t n : d.order) {
    const std::uint32_t r = d.receiver[n];
    if (r == n) continue;
    const double length = lattice.step * static_cast<double>(d.length[n]);
    const double below = static_cast<double>(ground.values[r]);
    double h = static_cast<double>(ground.values[n]);
    if (h <= below) continue;
    const double k =
        strength * rock.erodibility(n) * std::pow(d.area[n] * node_area, kAreaExponent) / length;
    h = (h + k * below) / (1.0 + k);
    h = std::min(h, below + length * rock.standing_slope(n, h));
    ground.values[n] = static_cast<float>(h);
  }
}

/// Material above the standing slope slides to the lower neighbours; then a little creep.
void slide_and_creep(PlanField& ground, const RockHardness& rock, double creep) {
  const PlanLattice& lattice = ground.lattice;
  const std::vector<float> before = ground.values;
  std::vector<double> change(before.size(), 0.0);
  for (int j = 1; j + 1 < lattice.ny; ++j) {
    for (int i = 1; i + 1 < lattice.nx; ++i) {
      const std::size_t n = lattice.index(i, j);
      const double h = static_cast<double>(before[n]);
      const double stands = rock.standing_slope(n, h);
      double mean = 0.0;
      for (int side = 0; side < 8; ++side) {
        const std::size_t m = lattice.index(i + kSides[side][0], j + kSides[side][1]);
        const double other = static_cast<double>(before[m]);
        if (side < 4) mean += 0.25 * other;
        const double excess = h - other - stands * lattice.step * side_length(side);
        if (excess <= 0.0) continue;
        change[n] -= 0.08 * excess;
        change[m] += 0.08 * excess;
      }
      change[n] += creep * (mean - h);
    }
  }
  for (int j = 1; j + 1 < lattice.ny; ++j) {
    for (int i = 1; i + 1 < lattice.nx; ++i) {
      const std::size_t n = lattice.index(i, j);
      ground.values[n] += static_cast<float>(change[n]);
    }
  }
}

void resample(const PlanField& from, PlanField& to) {
  for (int j = 0; j < to.lattice.ny; ++j) {
    for (int i = 0; i < to.lattice.nx; ++i) {
      to.at(i, j) = static_cast<float>(from.value(to.lattice.x(i), to.lattice.y(j)));
    }
  }
}

PlanLattice coarser(const PlanLattice& fine, int factor) {
  return {fine.x0, fine.y0, fine.step * factor, (fine.nx - 1) / factor + 2,
          (fine.ny - 1) / factor + 2};
}

}  // namespace

void erode(PlanField& ground, const ErosionShape& erosion, std::uint64_t seed) {
  if (erosion.incision <= 0.0) return;
  struct Level {
    int factor, rounds;
    double share;
  };
  constexpr Level kLevels[] = {{4, 12, 0.4}, {2, 9, 0.32}, {1, 7, 0.28}};
  for (const Level& level : kLevels) {
    PlanField coarse(coarser(ground.lattice, level.factor));
    PlanField& field = level.factor == 1 ? ground : coarse;
    if (level.factor > 1) resample(ground, coarse);
    const std::vector<float> before = coarse.values;
    const RockHardness rock(field.lattice, erosion, seed);
    for (int round = 0; round < level.rounds; ++round) {
      incise(field, rock, 1.6 * erosion.incision * level.share / level.rounds);
      slide_and_creep(field, rock, 0.02);
    }
    if (level.factor == 1) break;
    // The change alone goes back, so that detail finer than this level stays.
    for (std::size_t n = 0; n < before.size(); ++n) coarse.values[n] -= before[n];
    for (int j = 0; j < ground.lattice.ny; ++j) {
      for (int i = 0; i < ground.lattice.nx; ++i) {
        ground.at(i, j) +=
            static_cast<float>(coarse.value(ground.lattice.x(i), ground.lattice.y(j)));
      }
    }
  }
}

}  // namespace cornice::simulate
