// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/cracks/checker.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/base/random.h"

namespace cornice::bench {
namespace {

using namespace hlod;

constexpr std::uint32_t kNone = 0xffffffffu;

struct PositionHash {
  std::size_t operator()(const LatticePoint& p) const {
    const auto word = [](std::int32_t x) { return std::uint64_t{static_cast<std::uint32_t>(x)}; };
    return mix64(word(p.x) | word(p.y) << 32) ^ mix64(word(p.z) + 0x9e3779b97f4a7c15ULL);
  }
};
using PositionMap = std::unordered_map<LatticePoint, std::uint32_t, PositionHash>;

std::int64_t plan_or_all(const Metric& metric, std::int64_t x, std::int64_t y, std::int64_t z) {
  const std::int64_t plan = std::max(std::abs(x), std::abs(y));
  return metric.partition == Partition::kOctree ? std::max(plan, std::abs(z)) : plan;
}

}  // namespace

Hierarchy load_hierarchy(const std::filesystem::path& path) {
  const File file(path);
  Hierarchy h{file.header(), file.nodes(), {}};
  for (const Node& node : h.nodes) h.meshes.push_back(file.read(node));
  return h;
}

CrackChecker::CrackChecker(const Hierarchy& hierarchy)
    : hierarchy_(hierarchy), tree_(make_tree(hierarchy.header, hierarchy.nodes)) {
  levels_.resize(static_cast<std::size_t>(tree_.metric.finest_level) + 1);
  bands_.resize(levels_.size());
  parent_cell_.assign(tree_.cells.size(), kNone);
  drawn_check_.assign(tree_.cells.size(), 0);
  for (std::uint32_t c = 0; c < tree_.cells.size(); ++c) {
    const TreeCell& cell = tree_.cells[c];
    for (std::uint32_t n = 0; n < cell.children; ++n) parent_cell_[cell.first_child + n] = c;
  }
  number_vertices();
  measure_shares();
  find_border();
  find_neighbours();
}

void CrackChecker::number_vertices() {
  std::vector<PositionMap> numbers(levels_.size());
  vertex_of_.resize(hierarchy_.meshes.size());
  for (std::size_t m = 0; m < hierarchy_.meshes.size(); ++m) {
    const CellMesh& mesh = hierarchy_.meshes[m];
    const auto l = static_cast<std::size_t>(mesh.key.level);
    for (const CellVertex& v : mesh.vertices) {
      const auto [entry, is_new] =
          numbers[l].emplace(v.position, static_cast<std::uint32_t>(levels_[l].positions.size()));
      if (is_new) levels_[l].positions.push_back(v.position);
      vertex_of_[m].push_back(entry->second);
    }
  }
  for (Level& level : levels_) {
    level.parents.assign(level.positions.size(), kNone);
    level.drawn.assign(level.positions.size(), 0);
    level.stamp.assign(level.positions.size(), 0);
  }
  for (std::size_t m = 0; m < hierarchy_.meshes.size(); ++m) {
    const CellMesh& mesh = hierarchy_.meshes[m];
    const auto l = static_cast<std::size_t>(mesh.key.level);
    if (l == 0) continue;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const LatticePoint position = mesh.parents[mesh.parent_of[v]].position;
      // Where all triangles around a parent vanished, it is on its level without being in a cell.
      const auto [found, is_new] = numbers[l - 1].emplace(
          position, static_cast<std::uint32_t>(levels_[l - 1].positions.size()));
      if (is_new) {
        Level& above = levels_[l - 1];
        above.positions.push_back(position);
        above.parents.push_back(kNone), above.drawn.push_back(0), above.stamp.push_back(0);
      }
      std::uint32_t& parent = levels_[l].parents[vertex_of_[m][v]];
      if (parent != kNone && parent != found->second) {
        throw InputError(cell_name(mesh.key), "a vertex has two parents");
      }
      parent = found->second;
    }
  }
}

void CrackChecker::measure_shares() {
  const Metric& metric = tree_.metric;
  const double s0 = hierarchy_.header.edge_share;
  for (std::size_t m = 0; m < hierarchy_.meshes.size(); ++m) {
    const CellMesh& mesh = hierarchy_.meshes[m];
    // Side of a cell in steps of its own level.
    const double side = std::ldexp(1.0, metric.cell_bits);
    const auto length = [&](LatticePoint a, LatticePoint b) {
      return static_cast<double>(plan_or_all(metric, std::int64_t{a.x} - b.x,
                                             std::int64_t{a.y} - b.y, std::int64_t{a.z} - b.z));
    };
    for (std::size_t v = 0; v < mesh.parent_of.size(); ++v) {
      const LatticePoint parent = refined(mesh.parents[mesh.parent_of[v]].position);
      const double way = length(mesh.vertices[v].position, parent);
      parent_share_ = std::max(parent_share_, way / (0.5 * s0 * side));
    }
    for (const auto& t : mesh.triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double edge =
            length(mesh.vertices[t[c]].position, mesh.vertices[t[(c + 1) % 3]].position);
        edge_share_ = std::max(edge_share_, edge / (s0 * side));
      }
    }
  }
}

void CrackChecker::find_border() {
  struct Use {
    std::int32_t net = 0;
    std::uint32_t forth = kNone, back = kNone;  ///< a cell that uses it in either direction
  };
  std::map<std::array<std::uint32_t, 2>, Use> uses;
  const auto& finest = tree_.level(tree_.metric.finest_level);
  const std::uint32_t first = tree_.level_begin[levels_.size() - 1];
  cell_of_finest_.assign(levels_.back().positions.size(), kNone);
  for (std::uint32_t c = 0; c < finest.size(); ++c) {
    for (std::uint32_t m = finest[c].first_node; m < finest[c].first_node + finest[c].parts; ++m) {
      for (const std::uint32_t v : vertex_of_[m]) {
        if (cell_of_finest_[v] == kNone) cell_of_finest_[v] = first + c;
      }
      for (const auto& t : hierarchy_.meshes[m].triangles) {
        for (std::size_t e = 0; e < 3; ++e) {
          const std::uint32_t a = vertex_of_[m][t[e]], b = vertex_of_[m][t[(e + 1) % 3]];
          if (a == b) continue;
          Use& use = uses[{std::min(a, b), std::max(a, b)}];
          use.net += a < b ? 1 : -1;
          (a < b ? use.forth : use.back) = first + c;
        }
      }
    }
  }
  for (const auto& [edge, use] : uses) {
    if (use.net == 0) continue;
    border_.push_back({edge[0], edge[1], use.net > 0 ? use.forth : use.back, use.net});
  }
}

void CrackChecker::find_neighbours() {
  std::map<CellKey, std::uint32_t> cells;
  for (std::uint32_t c = tree_.level_begin[levels_.size() - 1]; c < tree_.cells.size(); ++c) {
    cells.emplace(tree_.cells[c].key, c);
  }
  const int depth = tree_.metric.partition == Partition::kOctree ? 1 : 0;
  for (const auto& [key, cell] : cells) {
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        for (int k = -depth; k <= depth; ++k) {
          const auto found = cells.find({key.level, key.i + i, key.j + j, key.k + k});
          if (found != cells.end() && found->second > cell) {
            neighbours_.push_back({cell, found->second});
          }
        }
      }
    }
  }
}

std::uint32_t CrackChecker::drawn_ancestor(std::uint32_t cell) const {
  while (cell != kNone && drawn_check_[cell] != check_) cell = parent_cell_[cell];
  return cell;
}

std::uint32_t CrackChecker::place_number(FinePoint p) {
  if (2 * (places_.size() + 1) > place_table_.size()) {
    place_table_.assign(std::max<std::size_t>(1024, 2 * place_table_.size()), kNone);
    for (std::uint32_t n = 0; n < places_.size(); ++n) {
      std::size_t slot = PositionHash{}(places_[n]) & (place_table_.size() - 1);
      while (place_table_[slot] != kNone) slot = (slot + 1) & (place_table_.size() - 1);
      place_table_[slot] = n;
    }
  }
  std::size_t slot = PositionHash{}(p) & (place_table_.size() - 1);
  for (; place_table_[slot] != kNone; slot = (slot + 1) & (place_table_.size() - 1)) {
    if (places_[place_table_[slot]] == p) return place_table_[slot];
  }
  place_table_[slot] = static_cast<std::uint32_t>(places_.size());
  places_.push_back(p);
  return place_table_[slot];
}

std::uint32_t CrackChecker::place(int l, std::uint32_t vertex) {
  Level& level = levels_[static_cast<std::size_t>(l)];
  if (level.stamp[vertex] == check_) return level.drawn[vertex];
  const LatticePoint own = level.positions[vertex];
  const int finer = tree_.metric.finest_level - l;
  FinePoint p = seen_from(eye_, own, finer);
  if (l > 0) {
    const LatticePoint parent =
        levels_[static_cast<std::size_t>(l) - 1].positions[level.parents[vertex]];
    p = morphed(own, parent, eye_, slab_, tree_.metric.partition,
                bands_[static_cast<std::size_t>(l)]);
  }
  level.stamp[vertex] = check_;
  return level.drawn[vertex] = place_number(p);
}

void CrackChecker::add_edge(std::uint32_t from, std::uint32_t to, std::int32_t times) {
  if (2 * (edge_count_ + 1) > edges_.size()) {
    std::vector<Edge> old(std::max<std::size_t>(4096, 2 * edges_.size()));
    old.swap(edges_);
    for (const Edge& edge : old) {
      if (edge.users == 0) continue;
      std::size_t slot = mix64(edge.key) & (edges_.size() - 1);
      while (edges_[slot].users != 0) slot = (slot + 1) & (edges_.size() - 1);
      edges_[slot] = edge;
    }
  }
  const std::uint64_t key = std::uint64_t{std::min(from, to)} << 32 | std::max(from, to);
  std::size_t slot = mix64(key) & (edges_.size() - 1);
  while (edges_[slot].users != 0 && edges_[slot].key != key) {
    slot = (slot + 1) & (edges_.size() - 1);
  }
  Edge& edge = edges_[slot];
  if (edge.users == 0) edge.key = key, ++edge_count_;
  edge.net += from < to ? times : -times;
  edge.users += static_cast<std::uint32_t>(std::abs(times));
}

void CrackChecker::add_cell(std::uint32_t c, Drawn& drawn) {
  const TreeCell& cell = tree_.cells[c];
  ++drawn.cells;
  for (std::uint32_t m = cell.first_node; m < cell.first_node + cell.parts; ++m) {
    for (const auto& t : hierarchy_.meshes[m].triangles) {
      std::array<std::uint32_t, 3> p{};
      for (std::size_t k = 0; k < 3; ++k) p[k] = place(cell.key.level, vertex_of_[m][t[k]]);
      ++drawn.triangles;
      if (p[0] == p[1] || p[1] == p[2] || p[2] == p[0]) {
        ++drawn.degenerate;
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) add_edge(p[k], p[(k + 1) % 3], 1);
    }
  }
}

/// What a vertex of the finest level has become at another; kNone where no cell has it.
std::uint32_t CrackChecker::ancestor(std::uint32_t vertex, int level) const {
  for (int l = tree_.metric.finest_level; l > level && vertex != kNone; --l) {
    vertex = levels_[static_cast<std::size_t>(l)].parents[vertex];
  }
  const bool has_parent =
      level == 0 ||
      (vertex != kNone && levels_[static_cast<std::size_t>(level)].parents[vertex] != kNone);
  return has_parent ? vertex : kNone;
}

/// The cells that stand for the surface now: those of the selection, and those of which nothing is
/// left at their level, which a selection leaves out.
void CrackChecker::mark_drawn(const Radii& radii) {
  std::size_t with_triangles = 0;
  std::vector<std::uint32_t> stack(tree_.level(0).size());
  for (std::uint32_t c = 0; c < stack.size(); ++c) stack[c] = c;
  while (!stack.empty()) {
    const std::uint32_t c = stack.back();
    stack.pop_back();
    const TreeCell& cell = tree_.cells[c];
    const std::int64_t radius = radii.of[static_cast<std::size_t>(cell.key.level)];
    if (cell.children == 0 || cell_distance(tree_, cell, eye_) >= radius) {
      drawn_check_[c] = check_;
      with_triangles += cell.parts > 0;
      continue;
    }
    for (std::uint32_t n = 0; n < cell.children; ++n) stack.push_back(cell.first_child + n);
  }
  const bool is_same = with_triangles == selection_.cells.size() &&
                       std::all_of(selection_.cells.begin(), selection_.cells.end(),
                                   [&](std::uint32_t c) { return drawn_check_[c] == check_; });
  if (!is_same) throw RunError("", "the selection is not what the rule says");
}

void CrackChecker::add_border() {
  for (const BorderEdge& edge : border_) {
    const std::uint32_t cell = drawn_ancestor(edge.cell);
    if (cell == kNone) continue;
    const int level = tree_.cells[cell].key.level;
    const std::uint32_t from = ancestor(edge.from, level), to = ancestor(edge.to, level);
    // Nothing is left of that part of the surface: its border runs forth and back.
    if (from == kNone || to == kNone) continue;
    const std::uint32_t a = place(level, from), b = place(level, to);
    if (a != b) add_edge(a, b, -edge.times);
  }
}

Drawn CrackChecker::check(FinePoint eye, const Radii& radii) {
  ++check_;
  eye_ = eye;
  slab_ = slab_distance(eye, tree_.metric);
  for (int l = 1; l <= tree_.metric.finest_level; ++l) {
    const auto i = static_cast<std::size_t>(l);
    if (radii.of[i - 1] > 0) bands_[i] = morph_band(radii, l, tree_.metric);
  }
  places_.clear();
  std::fill(place_table_.begin(), place_table_.end(), kNone);
  std::fill(edges_.begin(), edges_.end(), Edge{});
  edge_count_ = 0;
  select(tree_, radii, eye, {}, selection_);
  Drawn drawn;
  mark_drawn(radii);
  for (const std::uint32_t c : selection_.cells) add_cell(c, drawn);
  add_border();
  for (const Edge& edge : edges_) {
    drawn.open_edges += edge.net != 0 ? 1 : 0;
    drawn.crowded_edges += edge.net == 0 && edge.users > 2 ? 1 : 0;
  }
  for (const auto& [a, b] : neighbours_) {
    const std::uint32_t p = drawn_ancestor(a), q = drawn_ancestor(b);
    if (p == kNone || q == kNone) continue;
    drawn.level_jumps += std::abs(tree_.cells[p].key.level - tree_.cells[q].key.level) > 1 ? 1 : 0;
  }
  return drawn;
}

const std::vector<FinePoint>& CrackChecker::finest_vertices() {
  finest_.resize(levels_.back().positions.size());
  for (std::uint32_t v = 0; v < finest_.size(); ++v) {
    const std::uint32_t cell =
        cell_of_finest_[v] == kNone ? kNone : drawn_ancestor(cell_of_finest_[v]);
    if (cell == kNone) {
      finest_[v] = {};
      continue;
    }
    const int level = tree_.cells[cell].key.level;
    const std::uint32_t at = ancestor(v, level);
    finest_[v] = at == kNone ? FinePoint{} : places_[place(level, at)];
  }
  return finest_;
}

std::vector<std::array<FinePoint, 3>> CrackChecker::triangles() const {
  std::vector<std::array<FinePoint, 3>> list;
  for (const std::uint32_t c : selection_.cells) {
    const TreeCell& cell = tree_.cells[c];
    const Level& level = levels_[static_cast<std::size_t>(cell.key.level)];
    for (std::uint32_t m = cell.first_node; m < cell.first_node + cell.parts; ++m) {
      for (const auto& t : hierarchy_.meshes[m].triangles) {
        std::array<FinePoint, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = places_[level.drawn[vertex_of_[m][t[k]]]];
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
          continue;
        }
        list.push_back(corners);
      }
    }
  }
  return list;
}

double CrackChecker::error_bound_m() const {
  double bound = 0.0;
  for (const std::uint32_t c : selection_.cells) {
    const std::uint32_t at = parent_cell_[c] == kNone ? c : parent_cell_[c];
    bound = std::max(bound, double{tree_.cells[at].error_m});
  }
  return bound;
}

}  // namespace cornice::bench
