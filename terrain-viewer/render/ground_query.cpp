// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/ground_query.h"

namespace cornice::viewer {
namespace {

Vec3d position_of(const PackedCell& cell, std::uint16_t vertex) {
  const std::uint32_t* words = cell.words.data() + vertex * kWordsPerVertex;
  const std::uint64_t bits = words[0] | (std::uint64_t{words[1]} << 32);
  constexpr std::uint64_t kMask = (1u << 21) - 1;
  return {double(bits & kMask), double((bits >> 21) & kMask), double((bits >> 42) & kMask)};
}

}  // namespace

void heights_at(const PackedCell& cell, hlod::LatticePoint lowest, double x, double y,
                std::vector<double>& heights) {
  const double px = x - lowest.x, py = y - lowest.y;
  for (std::size_t i = 0; i + 2 < cell.indices.size(); i += 3) {
    const Vec3d a = position_of(cell, cell.indices[i]);
    const Vec3d b = position_of(cell, cell.indices[i + 1]);
    const Vec3d c = position_of(cell, cell.indices[i + 2]);
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (area == 0.0) continue;
    const double wb = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
    const double wc = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
    if (wb < 0.0 || wc < 0.0 || wb + wc > 1.0) continue;
    heights.push_back(lowest.z + a.z + wb * (b.z - a.z) + wc * (c.z - a.z));
  }
}

}  // namespace cornice::viewer
