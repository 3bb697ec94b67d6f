// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/plan.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "stages/stitch/join.h"

namespace cornice::stitch {
namespace {

Vec3d snapped(Vec3d p, double grid) {
  return {std::round(p.x / grid) * grid, std::round(p.y / grid) * grid,
          std::round(p.z / grid) * grid};
}

/// Where the vertices of a class come to lie: where they are if that is one place; else in their
/// middle, each tile counting once.
class Placing {
 public:
  Placing(const std::vector<Vec3d>& positions, double grid_m)
      : positions_(positions), grid_m_(grid_m) {}

  void place(const Place* begin, const Place* end, Plan& plan) const {
    Vec3d sum{}, tile_sum{};
    double tiles = 0.0, tile_places = 0.0;
    bool is_exact = true;
    for (const Place* p = begin; p != end; ++p) {
      tile_sum += at(*p);
      tile_places += 1.0;
      is_exact = is_exact && p->edge == kNone && at(*p) == at(*begin);
      if (p + 1 != end && p[1].tile == p->tile) continue;
      sum += tile_sum / tile_places;
      tiles += 1.0;
      tile_sum = {};
      tile_places = 0.0;
    }
    const Vec3d middle = is_exact ? at(*begin) : snapped(sum / tiles, grid_m_);
    for (const Place* p = begin; p != end; ++p) {
      plan.new_vertices += p->edge != kNone;
      plan.moved_vertices += p->edge == kNone && at(*p) != middle;
      plan.largest_move_m = std::max(plan.largest_move_m, norm(at(*p) - middle));
    }
    plan.positions.push_back(middle);
    plan.is_exact.push_back(is_exact);
  }

 private:
  Vec3d at(const Place& p) const {
    return positions_[p.a] + (positions_[p.b] - positions_[p.a]) * p.t;
  }
  const std::vector<Vec3d>& positions_;
  double grid_m_;
};

}  // namespace

Plan plan_borders(const Borders& borders, const Matches& matches, const JoinOptions& options) {
  Classes classes = join_matches(borders, matches);
  const std::vector<Insertion> inserted = join_loose_borders(borders, matches, options, classes);
  const std::vector<BorderEdge> edges = borders.edges();
  const std::vector<std::uint32_t> tiles = borders.vertex_tiles();

  struct Listed {
    std::uint32_t name;
    Place place;
  };
  std::vector<Listed> listed;
  for (std::uint32_t v = 0; v < borders.vertex_count(); ++v) {
    listed.push_back({classes.find(v), {tiles[v], v, v, 0.0, kNone}});
  }
  for (const Insertion& i : inserted) {
    const BorderEdge& edge = edges[i.edge];
    listed.push_back({classes.find(i.vertex), {tiles[edge.from], edge.from, edge.to, i.t, i.edge}});
  }
  std::sort(listed.begin(), listed.end(), [](const Listed& x, const Listed& y) {
    return std::tie(x.name, x.place.tile, x.place.edge, x.place.a) <
           std::tie(y.name, y.place.tile, y.place.edge, y.place.a);
  });
  Plan plan;
  plan.first.assign(1, 0);
  const std::vector<Vec3d> positions = borders.positions();
  const Placing placing(positions, options.grid_m);
  for (std::size_t i = 0; i < listed.size();) {
    std::size_t j = i;
    const std::size_t begin = plan.places.size();
    for (; j < listed.size() && listed[j].name == listed[i].name; ++j) {
      plan.places.push_back(listed[j].place);
    }
    if (j - i < 2) {
      plan.places.pop_back();
    } else {
      placing.place(plan.places.data() + begin, plan.places.data() + plan.places.size(), plan);
      plan.first.push_back(static_cast<std::uint32_t>(plan.places.size()));
    }
    i = j;
  }
  for (const BorderEdge& edge : edges) {
    plan.collapsed_edges += classes.find(edge.from) == classes.find(edge.to);
  }
  return plan;
}

}  // namespace cornice::stitch
