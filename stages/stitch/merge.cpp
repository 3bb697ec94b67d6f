// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/merge.h"

#include <utility>

#include "core/base/error.h"
#include "core/mesh/topology.h"

namespace cornice::stitch {

void Merger::add(const Mesh& tile, int threads) {
  if (first_) {
    mesh_.origin = tile.origin;
    mesh_.crs_text = tile.crs_text;
    for (const FloatProperty& p : tile.float_properties) mesh_.float_properties.push_back({p.name, {}});
    for (const ByteProperty& p : tile.byte_properties) mesh_.byte_properties.push_back({p.name, {}});
  }
  bool same = mesh_.float_properties.size() == tile.float_properties.size() &&
              mesh_.byte_properties.size() == tile.byte_properties.size() &&
              (first_ || mesh_.positions.empty() || mesh_.normals.empty() == tile.normals.empty());
  for (std::size_t p = 0; same && p < tile.float_properties.size(); ++p) {
    same = mesh_.float_properties[p].name == tile.float_properties[p].name;
  }
  for (std::size_t p = 0; same && p < tile.byte_properties.size(); ++p) {
    same = mesh_.byte_properties[p].name == tile.byte_properties[p].name;
  }
  if (!same) throw InputError("", "has other vertex properties than the first tile; they cannot be one mesh");
  first_ = false;
  const auto twins = match_half_edges(tile.triangles, tile.positions.size(), threads);
  const auto border = border_vertices(tile.triangles, twins, tile.positions.size());
  std::vector<std::uint32_t> to(tile.positions.size());
  for (std::uint32_t v = 0; v < to.size(); ++v) {
    const Vec3d p = tile.origin + tile.positions[v].cast<double>();
    const auto fresh = static_cast<std::uint32_t>(mesh_.positions.size());
    to[v] = fresh;
    if (border[v] != 0) {
      const auto [at, is_new] = border_.try_emplace({p.x, p.y, p.z}, fresh);
      to[v] = at->second;
      if (!is_new) continue;
    }
    mesh_.positions.push_back((p - mesh_.origin).cast<float>());
    if (!tile.normals.empty()) mesh_.normals.push_back(tile.normals[v]);
    for (std::size_t p2 = 0; p2 < tile.float_properties.size(); ++p2) {
      mesh_.float_properties[p2].values.push_back(tile.float_properties[p2].values[v]);
    }
    for (std::size_t p2 = 0; p2 < tile.byte_properties.size(); ++p2) {
      mesh_.byte_properties[p2].values.push_back(tile.byte_properties[p2].values[v]);
    }
  }
  for (const Triangle& t : tile.triangles) mesh_.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
}

}  // namespace cornice::stitch
