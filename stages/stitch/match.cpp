// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/match.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace cornice::stitch {
namespace {

/// Equal numbers for equal positions.
std::vector<std::uint32_t> number_positions(const Borders& borders) {
  const std::vector<Vec3d> positions = borders.positions();
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t v) {
    return std::tie(positions[v].x, positions[v].y, positions[v].z);
  };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  std::vector<std::uint32_t> number(positions.size());
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && key(order[i]) != key(order[i - 1])) ++count;
    number[order[i]] = count;
  }
  return number;
}

/// An edge by its ends, the lesser first.
struct Span {
  std::uint32_t low, high;
  bool is_forward;
  std::uint32_t tile, edge;
};

/// What one pair of positions holds: [begin, end) of spans with the same ends.
void match_span(const Span* begin, const Span* end, Matches& matches) {
  if (end - begin < 2 || begin->tile == (end - 1)->tile) return;  // inside one tile: its own affair
  if (end - begin > 2) {
    ++matches.non_manifold_edges;
  } else if (begin[0].is_forward == begin[1].is_forward) {
    ++matches.turned_edges;
  } else {
    matches.partner[begin[0].edge] = begin[1].edge;
    matches.partner[begin[1].edge] = begin[0].edge;
  }
}

}  // namespace

Matches match_edges(const Borders& borders) {
  const std::vector<std::uint32_t> number = number_positions(borders);
  std::vector<Span> spans;
  spans.reserve(borders.edge_count());
  for (std::uint32_t t = 0; t < borders.tiles.size(); ++t) {
    std::uint32_t id = borders.first_edge[t];
    for (const BorderEdge& edge : borders.tiles[t].edges) {
      const std::uint32_t from = number[borders.first_vertex[t] + edge.from];
      const std::uint32_t to = number[borders.first_vertex[t] + edge.to];
      spans.push_back({std::min(from, to), std::max(from, to), from < to, t, id++});
    }
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) {
    return std::tie(a.low, a.high, a.tile, a.edge) < std::tie(b.low, b.high, b.tile, b.edge);
  });
  Matches matches;
  matches.partner.assign(spans.size(), kNone);
  for (std::size_t i = 0; i < spans.size();) {
    std::size_t j = i + 1;
    while (j < spans.size() && spans[j].low == spans[i].low && spans[j].high == spans[i].high) ++j;
    if (spans[i].low != spans[i].high) match_span(&spans[i], spans.data() + j, matches);
    i = j;
  }
  return matches;
}

Classes::Classes(std::uint32_t count) : parent_(count) {
  std::iota(parent_.begin(), parent_.end(), 0u);
}

std::uint32_t Classes::find(std::uint32_t member) const {
  while (parent_[member] != member) {
    parent_[member] = parent_[parent_[member]];
    member = parent_[member];
  }
  return member;
}

void Classes::join(std::uint32_t a, std::uint32_t b) {
  a = find(a);
  b = find(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

Classes join_matches(const Borders& borders, const Matches& matches) {
  Classes classes(borders.vertex_count());
  const std::vector<BorderEdge> edges = borders.edges();
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    const std::uint32_t other = matches.partner[e];
    if (other == kNone || other < e) continue;
    classes.join(edges[e].from, edges[other].to);
    classes.join(edges[e].to, edges[other].from);
  }
  return classes;
}

}  // namespace cornice::stitch
