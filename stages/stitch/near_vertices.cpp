// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/near_vertices.h"

#include <algorithm>
#include <flann/flann.hpp>

namespace cornice::stitch {

std::vector<std::map<std::uint32_t, std::uint32_t>> nearest_vertices(const LooseBorders& loose,
                                                                     double tolerance_m) {
  const std::vector<std::uint32_t>& vertices = loose.loose_vertices();
  std::vector<std::map<std::uint32_t, std::uint32_t>> nearest(vertices.size());
  if (vertices.empty()) return nearest;
  std::vector<Vec3d> local;
  const Vec3d origin = loose.positions()[vertices.front()];
  for (const std::uint32_t v : vertices) local.push_back(loose.positions()[v] - origin);
  flann::Index<flann::L2_Simple<double>> index(flann::Matrix<double>(&local[0].x, local.size(), 3),
                                               flann::KDTreeSingleIndexParams(10));
  index.buildIndex();
  const auto radius_sq = static_cast<float>(tolerance_m * tolerance_m * 1.0001);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::vector<std::vector<std::size_t>> found(1);
    std::vector<std::vector<double>> distances_sq(1);
    index.radiusSearch(flann::Matrix<double>(&local[i].x, 1, 3), found, distances_sq, radius_sq,
                       flann::SearchParams(-1, 0.0f, false));
    std::sort(found[0].begin(), found[0].end());  // ties go to the lesser number
    const std::uint32_t v = vertices[i];
    for (const std::size_t other : found[0]) {
      const std::uint32_t w = vertices[other];
      if (loose.tile_of(w) == loose.tile_of(v) || !loose.may_join(v, w)) continue;
      const auto [best, is_new] = nearest[i].emplace(loose.tile_of(w), w);
      const auto distance = [&](std::uint32_t u) {
        return norm(loose.positions()[u] - loose.positions()[v]);
      };
      if (!is_new && distance(w) < distance(best->second)) best->second = w;
    }
  }
  return nearest;
}

}  // namespace cornice::stitch
