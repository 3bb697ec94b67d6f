// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/borders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace cornice::stitch {
namespace {

constexpr double kMismatch_m = 0.01;

using Place = std::array<double, 3>;
struct Owner {
  std::uint32_t tile;
  std::uint32_t index;
};

Place place(Vec3d p) { return {p.x, p.y, p.z}; }

/// Border vertices by cell of a plan grid, to look round a place.
class PlanGrid {
 public:
  PlanGrid(const std::vector<TileBorder>& tiles, double cell) : cell_(cell) {
    for (std::uint32_t t = 0; t < tiles.size(); ++t) {
      for (std::uint32_t i = 0; i < tiles[t].vertices.size(); ++i) {
        cells_[key(tiles[t].vertices[i].position)].push_back({t, i});
      }
    }
  }
  template <class Visit>
  void near(Vec3d p, Visit&& visit) const {
    const auto [x, y] = key(p);
    for (std::int64_t i = x - 1; i <= x + 1; ++i) {
      for (std::int64_t j = y - 1; j <= y + 1; ++j) {
        const auto found = cells_.find({i, j});
        if (found == cells_.end()) continue;
        for (const Owner& owner : found->second) visit(owner);
      }
    }
  }

 private:
  std::pair<std::int64_t, std::int64_t> key(Vec3d p) const {
    return {static_cast<std::int64_t>(std::floor(p.x / cell_)),
            static_cast<std::int64_t>(std::floor(p.y / cell_))};
  }
  double cell_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Owner>> cells_;
};

double distance_to_segment(Vec3d p, Vec3d a, Vec3d b, double& at) {
  const Vec3d ab = b - a;
  const double length_sq = dot(ab, ab);
  at = length_sq > 0.0 ? std::clamp(dot(p - a, ab) / length_sq, 0.0, 1.0) : 0.0;
  return norm(p - (a + ab * at));
}

}  // namespace

TileBorder find_border(const Mesh& mesh, int threads) {
  TileBorder border;
  border.origin = mesh.origin;
  const auto twins = match_half_edges(mesh.triangles, mesh.positions.size(), threads);
  std::set<std::pair<std::uint32_t, std::uint32_t>> bad;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3f> normals;
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    if (twins[h] < kNoTwin) continue;
    const Triangle& t = mesh.triangles[h / 3];
    const std::uint32_t a = t[h % 3], b = t[(h % 3 + 1) % 3];
    if (twins[h] == kNonManifoldEdge) {
      bad.insert(std::minmax(a, b));
      continue;
    }
    const Vec3f p = mesh.positions[t[0]];
    normals[{a, b}] = cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p);
  }
  border.non_manifold_edges = bad.size();
  for (const auto& loop : border_loops(mesh.triangles, twins, mesh.positions.size())) {
    const auto first = static_cast<std::uint32_t>(border.vertices.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::uint32_t v = loop[i], w = loop[(i + 1) % loop.size()];
      const auto here = static_cast<std::uint32_t>(border.vertices.size());
      border.vertices.push_back({mesh.origin + mesh.positions[v].cast<double>(), v,
                                 i + 1 == loop.size() ? first : here + 1});
      const auto normal = normals.find({v, w});
      border.edge_normals.push_back(normal == normals.end() ? Vec3f{} : normal->second);
    }
  }
  return border;
}

SeamReport check_seams(const std::vector<TileBorder>& tiles) {
  SeamReport report;
  std::map<Place, std::vector<Owner>> places;
  std::map<std::pair<Place, Place>, std::vector<Owner>> edges;
  double longest = 2.0 * kMismatch_m;
  for (std::uint32_t t = 0; t < tiles.size(); ++t) {
    report.non_manifold_edges += tiles[t].non_manifold_edges;
    for (std::uint32_t i = 0; i < tiles[t].vertices.size(); ++i) {
      const BorderVertex& v = tiles[t].vertices[i];
      const Vec3d end = tiles[t].vertices[v.next].position;
      places[place(v.position)].push_back({t, i});
      edges[{place(v.position), place(end)}].push_back({t, i});
      longest = std::max(longest, norm(end - v.position));
    }
  }
  const auto tiles_at = [&](Vec3d p) {
    std::set<std::uint32_t> found;
    for (const Owner& o : places.at(place(p))) found.insert(o.tile);
    return found;
  };
  const PlanGrid grid(tiles, std::min(longest, 50.0));
  for (std::uint32_t t = 0; t < tiles.size(); ++t) {
    for (std::uint32_t i = 0; i < tiles[t].vertices.size(); ++i) {
      const BorderVertex& v = tiles[t].vertices[i];
      const Vec3d end = tiles[t].vertices[v.next].position;
      const std::set<std::uint32_t> here = tiles_at(v.position);
      const bool shared = here.size() > 1;
      report.shared_vertices += shared;
      if (!shared) {
        bool mismatched = false;
        grid.near(v.position, [&](Owner o) {
          if (o.tile == t) return;
          mismatched = mismatched ||
                       norm(tiles[o.tile].vertices[o.index].position - v.position) <= kMismatch_m;
        });
        report.mismatched_vertices += mismatched;
      }
      const auto same = edges.at({place(v.position), place(end)});
      const auto other = edges.find({place(end), place(v.position)});
      if (same.size() > 1 || (other != edges.end() && other->second.size() > 1)) {
        ++report.non_manifold_edges;
      }
      if (other != edges.end() && other->second[0].tile != t) {
        ++report.shared_edges;
        const Owner o = other->second[0];
        report.flipped_neighbours +=
            dot(tiles[t].edge_normals[i], tiles[o.tile].edge_normals[o.index]) < 0.0f;
        continue;
      }
      const std::set<std::uint32_t> there = tiles_at(end);
      bool common = false;
      for (const std::uint32_t o : here) common = common || (o != t && there.count(o) > 0);
      report.open_edges += common;
      grid.near((v.position + end) * 0.5, [&](Owner o) {
        const Vec3d p = tiles[o.tile].vertices[o.index].position;
        double at = 0.0;
        if (o.tile == t || distance_to_segment(p, v.position, end, at) > kMismatch_m) return;
        if (norm(p - v.position) > kMismatch_m && norm(p - end) > kMismatch_m) ++report.t_vertices;
      });
    }
  }
  return report;
}

}  // namespace cornice::stitch
