// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/property/poisson_band/seams.h"

#include <array>
#include <cmath>
#include <map>
#include <string>

#include "core/mesh/topology.h"

namespace cornice::test {
namespace {

using Place = std::array<std::int64_t, 3>;

Place place_of(const Mesh& mesh, std::size_t v, const Lattice& lattice) {
  const Vec3d p = mesh.origin + mesh.positions[v].cast<double>();
  const double unit = lattice.step_m / kUnitsPerStep;
  return {std::llround(p.x / unit), std::llround(p.y / unit), std::llround(p.z / unit)};
}

/// Tiles on whose outline a place lies.
int outlines_at(const Place& p, std::span<const LatticeBox> tiles) {
  int count = 0;
  for (const LatticeBox& tile : tiles) {
    const std::int64_t x0 = std::int64_t{tile.x0} * kUnitsPerStep,
                       x1 = std::int64_t{tile.x1} * kUnitsPerStep,
                       y0 = std::int64_t{tile.y0} * kUnitsPerStep,
                       y1 = std::int64_t{tile.y1} * kUnitsPerStep;
    const bool touches = p[0] >= x0 && p[0] <= x1 && p[1] >= y0 && p[1] <= y1;
    count += touches && (p[0] == x0 || p[0] == x1 || p[1] == y0 || p[1] == y1);
  }
  return count;
}

}  // namespace

JoinedTiles join_tiles(std::span<const Surface> surfaces, std::span<const LatticeBox> tiles,
                       const Lattice& lattice) {
  struct Seen {
    std::uint32_t index;
    int times = 0;
    Vec3f normal;
    bool turned = false;
  };
  JoinedTiles joined;
  if (!surfaces.empty()) joined.mesh.origin = surfaces.front().mesh.origin;
  std::map<Place, Seen> seen;
  for (const Surface& surface : surfaces) {
    std::vector<std::uint32_t> number;
    for (std::size_t v = 0; v < surface.mesh.positions.size(); ++v) {
      const Place p = place_of(surface.mesh, v, lattice);
      const auto [entry, is_new] = seen.try_emplace(
          p, Seen{static_cast<std::uint32_t>(seen.size()), 0, surface.mesh.normals[v], false});
      if (is_new) {
        const Vec3d at =
            Vec3<std::int64_t>{p[0], p[1], p[2]}.cast<double>() * (lattice.step_m / kUnitsPerStep);
        joined.mesh.positions.push_back((at - joined.mesh.origin).cast<float>());
      }
      ++entry->second.times;
      entry->second.turned =
          entry->second.turned || !(entry->second.normal == surface.mesh.normals[v]);
      number.push_back(entry->second.index);
    }
    for (const auto& t : surface.mesh.triangles) {
      joined.mesh.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    }
  }
  std::vector<int> outlines(seen.size());
  for (const auto& [place, s] : seen) {
    outlines[s.index] = outlines_at(place, tiles);
    joined.mismatched += s.times != std::max(1, outlines[s.index]) && outlines[s.index] > 1;
    joined.turned += s.turned;
  }
  const auto& triangles = joined.mesh.triangles;
  const TopologyReport topology = check_topology(triangles, joined.mesh.positions.size(), 2);
  joined.non_manifold = topology.non_manifold_edges + topology.non_manifold_vertices +
                        topology.degenerate_triangles + topology.duplicate_triangles;
  const auto twins = match_half_edges(triangles, joined.mesh.positions.size(), 2);
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    if (twins[h] != kOpenEdge) continue;
    const std::uint32_t a = triangles[h / 3][h % 3], b = triangles[h / 3][(h + 1) % 3];
    // Both ends on the outline of one tile alone: the edge of the survey or of a hole. An end in a
    // corner may be on two.
    joined.open_edges +=
        outlines[a] == 0 || outlines[b] == 0 || (outlines[a] > 1 && outlines[b] > 1);
  }
  return joined;
}

std::vector<Surface> extract_all(std::span<const TileField> fields, int threads) {
  std::vector<Surface> surfaces;
  for (std::size_t t = 0; t < fields.size(); ++t) {
    std::vector<TileField> bands;
    std::vector<std::string> names{"own"};
    for (std::size_t n = 0; n < fields.size(); ++n) {
      if (n == t) continue;
      bands.push_back(make_band(fields[n]));
      names.push_back("tile " + std::to_string(n));
    }
    const BlendedValues values(fields[t], bands, names);
    ExtractOptions options;
    options.window = fields[t].tile;
    options.borders = values.tiles();
    options.threads = threads;
    surfaces.push_back(extract_surface(values, fields[t].field.lattice(), options));
  }
  return surfaces;
}

}  // namespace cornice::test
