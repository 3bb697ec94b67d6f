// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/topology.h"

#include <algorithm>
#include <atomic>
#include <map>

#include "core/base/parallel.h"

namespace cornice {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 16;

std::uint32_t start_of(const std::vector<Triangle>& triangles, std::uint32_t h) {
  return triangles[h / 3][h % 3];
}
std::uint32_t end_of(const std::vector<Triangle>& triangles, std::uint32_t h) {
  return triangles[h / 3][(h % 3 + 1) % 3];
}

/// Matches the half-edges of one bucket: all of them have the same lower vertex.
void match_bucket(const std::vector<Triangle>& triangles, std::uint32_t* begin, std::uint32_t* end,
                  std::vector<std::uint32_t>& twins) {
  const auto other = [&](std::uint32_t h) {
    return std::max(start_of(triangles, h), end_of(triangles, h));
  };
  std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t va = other(a), vb = other(b);
    return va != vb ? va < vb : a < b;
  });
  for (std::uint32_t* at = begin; at != end;) {
    std::uint32_t* stop = at + 1;
    while (stop != end && other(*stop) == other(*at)) ++stop;
    const std::ptrdiff_t edges = stop - at;
    if (edges == 1) {
      twins[at[0]] = kOpenEdge;
    } else if (edges == 2 && start_of(triangles, at[0]) != start_of(triangles, at[1])) {
      twins[at[0]] = at[1];
      twins[at[1]] = at[0];
    } else {
      for (std::uint32_t* h = at; h != stop; ++h) twins[*h] = kNonManifoldEdge;
    }
    at = stop;
  }
}

bool names_a_vertex_twice(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

}  // namespace

std::vector<std::uint32_t> match_half_edges(const std::vector<Triangle>& triangles,
                                            std::size_t vertex_count, int threads) {
  std::vector<std::uint32_t> twins(triangles.size() * 3, kNonManifoldEdge);
  std::vector<std::uint32_t> first(vertex_count + 1, 0);
  const auto each_half_edge = [&](auto&& visit) {
    parallel_for(triangles.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        if (names_a_vertex_twice(triangles[t])) continue;
        for (std::uint32_t k = 0; k < 3; ++k) {
          visit(std::min(triangles[t][k], triangles[t][(k + 1) % 3]),
                static_cast<std::uint32_t>(3 * t + k));
        }
      }
    });
  };
  each_half_edge([&](std::uint32_t low, std::uint32_t) {
    std::atomic_ref(first[low + 1]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::size_t v = 0; v < vertex_count; ++v) first[v + 1] += first[v];
  std::vector<std::uint32_t> buckets(first[vertex_count]);
  {
    std::vector<std::uint32_t> at(first.begin(), first.end() - 1);
    each_half_edge([&](std::uint32_t low, std::uint32_t h) {
      buckets[std::atomic_ref(at[low]).fetch_add(1, std::memory_order_relaxed)] = h;
    });
  }
  // Threads filled the buckets in any order; sorting each makes the result a function of the input.
  parallel_for(vertex_count, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      match_bucket(triangles, buckets.data() + first[v], buckets.data() + first[v + 1], twins);
    }
  });
  return twins;
}

std::vector<std::uint8_t> border_vertices(const std::vector<Triangle>& triangles,
                                          const std::vector<std::uint32_t>& twins,
                                          std::size_t vertex_count,
                                          std::vector<std::uint8_t>* bad_vertices) {
  // A fan is a closed ring, or starts at one outgoing edge without twin. Walking round from one
  // corner of each vertex reaches as many corners as its fan has.
  std::vector<std::uint8_t> border(vertex_count, 0), bad(vertex_count, 0);
  std::vector<std::uint32_t> corners(vertex_count, 0), some_corner(vertex_count, kOpenEdge);
  std::vector<std::uint32_t> open_start(vertex_count, kOpenEdge);
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    const std::uint32_t v = start_of(triangles, h);
    ++corners[v];
    some_corner[v] = std::min(some_corner[v], h);
    if (twins[h] >= kNoTwin) {
      const std::uint32_t w = end_of(triangles, h);
      border[v] = border[w] = 1;
      if (twins[h] == kNonManifoldEdge) bad[v] = bad[w] = 1;
      open_start[v] = std::min(open_start[v], h);
    }
  }
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (corners[v] == 0 || bad[v] != 0) continue;
    const std::uint32_t start = open_start[v] != kOpenEdge ? open_start[v] : some_corner[v];
    std::uint32_t reached = 0;
    std::uint32_t h = start;
    do {
      ++reached;
      h = twins[previous_half_edge(h)];
    } while (h < kNoTwin && h != start && reached <= corners[v]);
    if (reached != corners[v]) bad[v] = border[v] = 1;
  }
  if (bad_vertices != nullptr) *bad_vertices = std::move(bad);
  return border;
}

TopologyReport check_topology(const std::vector<Triangle>& triangles, std::size_t vertex_count,
                              int threads) {
  TopologyReport report;
  const std::vector<std::uint32_t> twins = match_half_edges(triangles, vertex_count, threads);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> bad_edges;
  std::vector<std::uint8_t> used(vertex_count, 0);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corners = triangles[t];
    for (const std::uint32_t v : corners) used[v] = 1;
    if (names_a_vertex_twice(corners)) {
      ++report.degenerate_triangles;
      continue;
    }
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      if (twins[h] == kOpenEdge) ++report.open_edges;
      if (twins[h] == kNonManifoldEdge) {
        ++bad_edges[std::minmax(start_of(triangles, h), end_of(triangles, h))];
      }
    }
  }
  report.non_manifold_edges = bad_edges.size();
  for (const std::uint8_t u : used) report.isolated_vertices += u == 0;
  std::vector<std::uint8_t> bad;
  border_vertices(triangles, twins, vertex_count, &bad);
  std::vector<std::uint8_t> on_bad_edge(vertex_count, 0);
  for (const auto& [edge, count] : bad_edges)
    on_bad_edge[edge.first] = on_bad_edge[edge.second] = 1;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    report.non_manifold_vertices += bad[v] != 0 && on_bad_edge[v] == 0;
  }
  std::vector<Triangle> sorted = triangles;
  for (Triangle& t : sorted) std::sort(t.begin(), t.end());
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t t = 1; t < sorted.size(); ++t) {
    report.duplicate_triangles += sorted[t] == sorted[t - 1] && !names_a_vertex_twice(sorted[t]);
  }
  std::uint32_t components = 0;
  triangle_components(triangles, twins, components);
  report.components = components;
  return report;
}

std::vector<std::vector<std::uint32_t>> border_loops(const std::vector<Triangle>& triangles,
                                                     const std::vector<std::uint32_t>& twins,
                                                     std::size_t /*vertex_count*/) {
  std::vector<std::vector<std::uint32_t>> loops;
  std::vector<std::uint8_t> seen(twins.size(), 0);
  for (std::uint32_t first = 0; first < twins.size(); ++first) {
    if (twins[first] != kOpenEdge || seen[first] != 0) continue;
    std::vector<std::uint32_t> loop;
    std::uint32_t h = first;
    while (seen[h] == 0) {
      seen[h] = 1;
      loop.push_back(start_of(triangles, h));
      // The next open edge starts at the end of this one, on the same fan.
      std::uint32_t turn = next_half_edge(h);
      while (twins[turn] < kNoTwin) turn = next_half_edge(twins[turn]);
      if (twins[turn] != kOpenEdge) break;
      h = turn;
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<std::uint32_t> triangle_components(const std::vector<Triangle>& triangles,
                                               const std::vector<std::uint32_t>& twins,
                                               std::uint32_t& count) {
  std::vector<std::uint32_t> label(triangles.size(), kOpenEdge);
  std::vector<std::uint32_t> front;
  count = 0;
  for (std::uint32_t first = 0; first < triangles.size(); ++first) {
    if (label[first] != kOpenEdge) continue;
    label[first] = count;
    front.assign(1, first);
    while (!front.empty()) {
      const std::uint32_t t = front.back();
      front.pop_back();
      for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        if (twins[h] >= kNoTwin || label[twins[h] / 3] != kOpenEdge) continue;
        label[twins[h] / 3] = count;
        front.push_back(twins[h] / 3);
      }
    }
    ++count;
  }
  return label;
}

}  // namespace cornice
