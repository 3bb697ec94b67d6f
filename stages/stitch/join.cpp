// SPDX-License-Identifier: GPL-3.0-or-later
// After the stitching of the reference: vertices of one side go to the nearest of the other, what
// lies between collapses. Here nearest is meant in space, of vertices or edges, and the sides give
// way alike; every decision follows from positions, which both sides have.
#include "stages/stitch/join.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "stages/stitch/edge_grid.h"
#include "stages/stitch/near_vertices.h"
#include "stages/stitch/plan.h"

namespace cornice::stitch {
namespace {

/// A vertex nearer to the end of an edge than this share of its length is not put into the edge
/// where its own border may give it up instead: the triangles there would be thin.
constexpr double kShortShare = 0.2;

/// Two vertices of different tiles, each the other's nearest.
struct Pair {
  std::uint32_t v, w;
  std::uint32_t tiles;  ///< that have a vertex near either
  double distance_m;
};

/// Mutual nearest vertices, in the order in which they are joined: corners of several tiles first.
std::vector<Pair> mutual_pairs(const LooseBorders& loose, double tolerance_m) {
  const std::vector<std::uint32_t>& vertices = loose.loose_vertices();
  const auto nearest = nearest_vertices(loose, tolerance_m);
  const auto at = [&](std::uint32_t v) {
    return static_cast<std::size_t>(std::lower_bound(vertices.begin(), vertices.end(), v) -
                                    vertices.begin());
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::uint32_t v = vertices[i];
    for (const auto& [tile, w] : nearest[i]) {
      if (w < v) continue;
      const auto& back = nearest[at(w)];
      const auto found = back.find(loose.tile_of(v));
      if (found == back.end() || found->second != v) continue;
      const auto tiles = static_cast<std::uint32_t>(std::max(nearest[i].size(), back.size()));
      pairs.push_back({v, w, tiles, norm(loose.positions()[v] - loose.positions()[w])});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::make_tuple(~a.tiles, a.distance_m, a.v, a.w) <
           std::make_tuple(~b.tiles, b.distance_m, b.v, b.w);
  });
  return pairs;
}

/// Joins vertices into classes that have at most one place on each tile's border.
class Joiner {
 public:
  Joiner(const Borders& borders, const LooseBorders& loose, Classes& classes)
      : loose_(loose), classes_(classes) {
    for (std::uint32_t v = 0; v < borders.vertex_count(); ++v) {
      const std::uint32_t name = classes_.find(v);
      if (name == v && !loose.is_loose(v)) continue;
      tiles_[name].insert({loose.tile_of(v), loose.tile_of(name)});
    }
  }

  bool has_tile(std::uint32_t v, std::uint32_t tile) {
    return tiles_[classes_.find(v)].contains(tile);
  }
  std::size_t tile_count(std::uint32_t v) { return tiles_[classes_.find(v)].size(); }
  void add_tile(std::uint32_t v, std::uint32_t tile) { tiles_[classes_.find(v)].insert(tile); }

  /// Joins unless a tile has a place in both.
  bool join(std::uint32_t v, std::uint32_t w) {
    const std::set<std::uint32_t>& a = tiles_[classes_.find(v)];
    for (const std::uint32_t tile : tiles_[classes_.find(w)]) {
      if (a.contains(tile)) return false;
    }
    merge(v, w);
    return true;
  }
  /// Joins the ends of an edge.
  void collapse(std::uint32_t edge) { merge(loose_.edges()[edge].from, loose_.edges()[edge].to); }

 private:
  void merge(std::uint32_t v, std::uint32_t w) {
    std::set<std::uint32_t> both = tiles_[classes_.find(v)];
    both.merge(std::set<std::uint32_t>(tiles_[classes_.find(w)]));
    classes_.join(v, w);
    tiles_[classes_.find(v)] = std::move(both);
  }
  const LooseBorders& loose_;
  Classes& classes_;
  std::map<std::uint32_t, std::set<std::uint32_t>> tiles_;
};

/// Gives up vertices that fall just beside an end of the other side's edge, where their own border
/// has a vertex at that end: the short edge between collapses.
void collapse_short_edges(const LooseBorders& loose, double tolerance_m, Classes& classes,
                          Joiner& joiner) {
  for (const std::uint32_t v : loose.loose_vertices()) {
    if (joiner.tile_count(v) > 1) continue;
    for (const LooseBorders::Near& near : loose.edges_near(v)) {
      const BorderEdge& edge = loose.edges()[near.edge];
      if (std::min(near.t, 1.0 - near.t) >= kShortShare) continue;
      const std::uint32_t end = near.t < 0.5 ? edge.from : edge.to;
      for (const std::uint32_t own : {loose.in(v), loose.out(v)}) {
        if (own == kNone || !loose.edges()[own].is_collapsible) continue;
        const std::uint32_t u =
            loose.edges()[own].from == v ? loose.edges()[own].to : loose.edges()[own].from;
        if (classes.find(u) != classes.find(end) || loose.length(own) > tolerance_m) continue;
        joiner.collapse(own);
        break;
      }
      if (joiner.tile_count(v) > 1) break;
    }
  }
}

/// Vertices that other tiles' edges get.
std::vector<Insertion> insert_vertices(const LooseBorders& loose, const Classes& classes,
                                       Joiner& joiner) {
  struct Candidate {
    double distance_m;
    Insertion insertion;
  };
  std::vector<Candidate> candidates;
  for (const std::uint32_t v : loose.loose_vertices()) {
    for (const LooseBorders::Near& near : loose.edges_near(v)) {
      candidates.push_back({near.distance_m, {near.edge, near.t, v}});
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.distance_m, a.insertion.vertex, a.insertion.edge) <
           std::tie(b.distance_m, b.insertion.vertex, b.insertion.edge);
  });
  std::vector<Insertion> inserted;
  for (const Candidate& c : candidates) {
    const BorderEdge& edge = loose.edges()[c.insertion.edge];
    const std::uint32_t tile = loose.tile_of(edge.from);
    if (joiner.has_tile(c.insertion.vertex, tile)) continue;
    if (classes.find(edge.from) == classes.find(edge.to)) continue;
    joiner.add_tile(c.insertion.vertex, tile);
    inserted.push_back(c.insertion);
  }
  std::sort(inserted.begin(), inserted.end(), [](const Insertion& a, const Insertion& b) {
    return std::tie(a.edge, a.t, a.vertex) < std::tie(b.edge, b.t, b.vertex);
  });
  return inserted;
}

/// Puts between two classes what another tile has between them and an edge has not: vertices of
/// which no place of the edge is the nearest, where borders bend.
///
///   tile A   x────v────y        x, y are one with p, q of tile B, v with nothing:
///   tile B   p─────────q        v goes into the edge from q to p, as all between x and y
class Between {
 public:
  Between(const LooseBorders& loose, double tolerance_m, const Classes& classes, Joiner& joiner,
          std::vector<Insertion>& inserted)
      : loose_(loose), tolerance_m_(tolerance_m), classes_(classes), joiner_(joiner) {
    for (const Insertion& i : inserted) on_edge_[i.edge].push_back(i);
    for (const std::uint32_t v : loose.loose_vertices()) of_class_.emplace(classes.find(v), v);
  }

  std::vector<Insertion> complete() {
    for (const std::uint32_t e : loose_.loose_edges()) complete_edge(e);
    std::vector<Insertion> all;
    for (const auto& [edge, list] : on_edge_) all.insert(all.end(), list.begin(), list.end());
    return all;
  }

 private:
  /// More vertices than this in one edge are no bend.
  static constexpr std::size_t kMost = 64;

  void complete_edge(std::uint32_t e) {
    const BorderEdge& edge = loose_.edges()[e];
    const std::uint32_t start = classes_.find(edge.to), stop = classes_.find(edge.from);
    if (start == stop) return;
    const auto [first, last] = of_class_.equal_range(start);
    for (auto at = first; at != last; ++at) {
      if (loose_.tile_of(at->second) == loose_.tile_of(edge.to)) continue;
      const std::vector<std::uint32_t> path = path_between(at->second, stop);
      if (!path.empty() && may_insert(e, path)) return insert(e, path);
    }
  }

  /// Vertices after `v` along its border up to one of class `stop`; empty where that is not
  /// reached.
  std::vector<std::uint32_t> path_between(std::uint32_t v, std::uint32_t stop) const {
    std::vector<std::uint32_t> path;
    std::uint32_t last = classes_.find(v);
    while (path.size() < kMost && loose_.out(v) != kNone) {
      v = loose_.edges()[loose_.out(v)].to;
      if (classes_.find(v) == stop) return path;
      if (classes_.find(v) != last) path.push_back(v);
      last = classes_.find(v);
    }
    return {};
  }

  double place_on(std::uint32_t e, std::uint32_t v) const {
    const Vec3d along = loose_.along(e);
    const Vec3d from = loose_.positions()[v] - loose_.positions()[loose_.edges()[e].from];
    return std::clamp(dot(from, along) / std::max(dot(along, along), 1e-30), 0.0, 1.0);
  }

  /// All of the path is near the edge, and lies nowhere else on its tile's border; nothing but the
  /// path is on the edge, and not all of it is there already.
  bool may_insert(std::uint32_t e, const std::vector<std::uint32_t>& path) {
    const BorderEdge& edge = loose_.edges()[e];
    std::set<std::uint32_t> there;
    const auto known = on_edge_.find(e);
    if (known != on_edge_.end()) {
      for (const Insertion& i : known->second) there.insert(classes_.find(i.vertex));
    }
    std::size_t met = 0;
    for (const std::uint32_t v : path) {
      const bool is_there = there.contains(classes_.find(v));
      met += is_there;
      if (!is_there && joiner_.has_tile(v, loose_.tile_of(edge.from))) return false;
      const Vec3d on = loose_.positions()[edge.from] + loose_.along(e) * place_on(e, v);
      if (norm(loose_.positions()[v] - on) > tolerance_m_) return false;
    }
    return met == there.size() && !(met == path.size() && is_in_order(e, path));
  }

  bool is_in_order(std::uint32_t e, const std::vector<std::uint32_t>& path) const {
    const std::vector<Insertion>& list = on_edge_.at(e);
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (classes_.find(list[list.size() - 1 - i].vertex) != classes_.find(path[i])) return false;
    }
    return true;
  }

  void insert(std::uint32_t e, const std::vector<std::uint32_t>& path) {
    const std::uint32_t tile = loose_.tile_of(loose_.edges()[e].from);
    std::vector<Insertion> list;
    bool is_rising = true;
    for (auto v = path.rbegin(); v != path.rend(); ++v) {
      const double t = place_on(e, *v);
      is_rising = is_rising && t > (list.empty() ? 0.0 : list.back().t) && t < 1.0;
      list.push_back({e, t, *v});
      if (!joiner_.has_tile(*v, tile)) joiner_.add_tile(*v, tile);
    }
    for (std::size_t i = 0; !is_rising && i < list.size(); ++i) {
      list[i].t = static_cast<double>(i + 1) / static_cast<double>(list.size() + 1);
    }
    on_edge_[e] = std::move(list);
  }

  const LooseBorders& loose_;
  const double tolerance_m_;
  const Classes& classes_;
  Joiner& joiner_;
  std::map<std::uint32_t, std::vector<Insertion>> on_edge_;
  std::multimap<std::uint32_t, std::uint32_t> of_class_;
};

}  // namespace

std::vector<Insertion> join_loose_borders(const Borders& borders, const Matches& matches,
                                          const JoinOptions& options, Classes& classes) {
  const LooseBorders loose(borders, matches, options.tolerance_m);
  Joiner joiner(borders, loose, classes);
  for (const Pair& pair : mutual_pairs(loose, options.tolerance_m)) joiner.join(pair.v, pair.w);
  collapse_short_edges(loose, options.tolerance_m, classes, joiner);
  std::vector<Insertion> inserted = insert_vertices(loose, classes, joiner);
  return Between(loose, options.tolerance_m, classes, joiner, inserted).complete();
}

}  // namespace cornice::stitch
