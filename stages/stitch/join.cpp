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

}  // namespace

std::vector<Insertion> join_loose_borders(const Borders& borders, const Matches& matches,
                                          const JoinOptions& options, Classes& classes) {
  const LooseBorders loose(borders, matches, options.tolerance_m);
  Joiner joiner(borders, loose, classes);
  for (const Pair& pair : mutual_pairs(loose, options.tolerance_m)) joiner.join(pair.v, pair.w);
  collapse_short_edges(loose, options.tolerance_m, classes, joiner);
  return insert_vertices(loose, classes, joiner);
}

}  // namespace cornice::stitch
