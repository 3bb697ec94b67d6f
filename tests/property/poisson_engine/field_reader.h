// SPDX-License-Identifier: GPL-3.0-or-later
// Where a field is zero.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "core/base/vec.h"
#include "stages/poisson/field.h"

namespace cornice {

/// Value and gradient (per metre) of a field.
struct FieldSample {
  double value = 0.0;
  Vec3d gradient;
};

/// Nothing where no level covers the place.
inline std::optional<FieldSample> read_field(const Field& field, Vec3d place) {
  const double h = field.lattice().step_m;
  const Vec3d s = place / h;
  const Vec3d low{std::floor(s.x), std::floor(s.y), std::floor(s.z)};
  const auto i = static_cast<int>(low.x), j = static_cast<int>(low.y), k = static_cast<int>(low.z);
  std::array<float, kClosedBrickNodes> closed;
  if (!field.closed_brick(0, {i >> 3, j >> 3, k >> 3}, closed)) return std::nullopt;
  const Vec3d t = s - low;
  FieldSample sample;
  for (int o = 0; o < 8; ++o) {
    const int dx = o & 1, dy = o >> 1 & 1, dz = o >> 2;
    const double value = closed[(i & 7) + dx + 9 * ((j & 7) + dy + 9 * ((k & 7) + dz))];
    const double wx = dx ? t.x : 1 - t.x, wy = dy ? t.y : 1 - t.y, wz = dz ? t.z : 1 - t.z;
    sample.value += wx * wy * wz * value;
    sample.gradient +=
        Vec3d{(dx ? 1 : -1) * wy * wz, (dy ? 1 : -1) * wx * wz, (dz ? 1 : -1) * wx * wy} *
        (value / h);
  }
  return sample;
}

/// Distance from `place` along the unit vector `along` to where the field is zero, within `reach_m`
/// on either side: the nearest change of sign, found by steps of a tenth of the lattice step.
inline std::optional<double> distance_to_zero(const Field& field, Vec3d place, Vec3d along,
                                              double reach_m) {
  const double step = 0.1 * field.lattice().step_m;
  std::optional<double> nearest;
  for (const double direction : {1.0, -1.0}) {
    std::optional<FieldSample> last = read_field(field, place);
    for (double d = step; last && d <= reach_m; d += step) {
      const std::optional<FieldSample> next = read_field(field, place + along * (direction * d));
      if (!next) break;
      if ((last->value < 0.0) != (next->value < 0.0)) {
        const double at = d - step + step * last->value / (last->value - next->value);
        if (!nearest || at < std::abs(*nearest)) nearest = direction * at;
        break;
      }
      last = next;
    }
  }
  return nearest;
}

}  // namespace cornice
