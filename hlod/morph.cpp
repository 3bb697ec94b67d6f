// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/morph.h"

#include <cassert>
#include <cmath>

namespace cornice::hlod {
namespace {

/// Of the way to where a level ends, the part that it morphs over; of a cell's side, the least.
/// Wider bands change slower and draw more of the ground as its parents (decision 600 has both
/// measured).
constexpr std::int64_t kBandPart = 16, kBandSidePart = 8;

}  // namespace

std::int32_t Metric::share(int level) const {
  return static_cast<std::int32_t>(std::ceil(edge_share * side(level)));
}

FinePoint fine_eye(Vec3d eye, const Lattice& lattice) {
  const double step = lattice.step(lattice.finest_level);
  const auto held = [&](double metres) {
    const double limit = 0x1p30;
    // An eye that is no number is at the origin rather than anywhere.
    const double steps = std::floor(metres / step);
    return static_cast<std::int32_t>(std::isnan(steps) ? 0.0 : std::clamp(steps, -limit, limit));
  };
  const Vec3d p = eye - lattice.origin;
  return {held(p.x), held(p.y), held(p.z)};
}

MorphBand morph_band(const Radii& radii, int level, const Metric& metric) {
  assert(level > 0 && level <= metric.finest_level && "the root does not morph");
  const auto l = static_cast<std::size_t>(level);
  assert(radii.of[l - 1] > 0 && "a level that is not drawn has no band");
  const std::int64_t end = radii.of[l - 1] - 2 * std::int64_t{metric.share(level)};
  const std::int64_t earliest = radii.of[l] + metric.side(level) + metric.share(level);
  assert(end > earliest && "radii too near each other");
  const std::int64_t width = std::max(end / kBandPart, metric.side(level) / kBandSidePart);
  const std::int64_t start = std::max(earliest, end - width);
  MorphBand m;
  m.finer = metric.finest_level - level;
  m.end = static_cast<std::int32_t>(end);
  while (((end - start) >> m.shift) > 32767) ++m.shift;
  m.band = static_cast<std::int32_t>((end - start) >> m.shift);
  return m;
}

}  // namespace cornice::hlod
