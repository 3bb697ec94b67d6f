// SPDX-License-Identifier: GPL-3.0-or-later
// The tree of a file's nodes: children side by side, so that no lookup is needed while it is
// walked.
#include <algorithm>
#include <cassert>
#include <tuple>

#include "hlod/select.h"

namespace cornice::hlod {
namespace {

constexpr FinePoint kNowhereLow{1 << 30, 1 << 30, 1 << 30};
constexpr FinePoint kNowhereHigh{-(1 << 30), -(1 << 30), -(1 << 30)};

FinePoint least(FinePoint a, FinePoint b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
FinePoint most(FinePoint a, FinePoint b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
FinePoint fine(LatticePoint p, int finer) { return {p.x << finer, p.y << finer, p.z << finer}; }

/// One cell per key, its parts together.
std::vector<std::vector<TreeCell>> cells_by_level(const Lattice& lattice,
                                                  std::span<const Node> nodes) {
  std::vector<std::vector<TreeCell>> levels(static_cast<std::size_t>(lattice.finest_level) + 1);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Node& node = nodes[n];
    auto& level = levels[static_cast<std::size_t>(node.key.level)];
    if (node.part == 0) {
      TreeCell cell;
      cell.key = node.key;
      cell.lowest = kNowhereLow, cell.highest = kNowhereHigh;
      cell.first_node = static_cast<std::uint32_t>(n);
      level.push_back(cell);
    }
    TreeCell& cell = level.back();
    const int finer = lattice.finest_level - node.key.level;
    cell.lowest = least(cell.lowest, fine(node.lowest, finer));
    cell.highest = most(cell.highest, fine(node.highest, finer));
    cell.error_m = std::max(cell.error_m, node.error_m);
    cell.triangles += node.triangles;
    ++cell.parts;
  }
  return levels;
}

/// Cells of which nothing is left at their level have no node, but finer cells below them. Every
/// level but the coarsest gets a parent; levels stay sorted by key.
void add_missing_parents(std::vector<std::vector<TreeCell>>& levels) {
  const auto by_key = [](const TreeCell& a, const TreeCell& b) { return a.key < b.key; };
  for (std::size_t l = levels.size(); l-- > 1;) {
    std::vector<TreeCell> missing;
    for (const TreeCell& child : levels[l]) {
      TreeCell parent;
      parent.key = child.key.parent();
      parent.lowest = kNowhereLow, parent.highest = kNowhereHigh;
      if (!std::binary_search(levels[l - 1].begin(), levels[l - 1].end(), parent, by_key)) {
        missing.push_back(parent);
      }
    }
    std::sort(missing.begin(), missing.end(), by_key);
    const auto same = [](const TreeCell& a, const TreeCell& b) { return a.key == b.key; };
    missing.erase(std::unique(missing.begin(), missing.end(), same), missing.end());
    const auto middle = static_cast<std::ptrdiff_t>(levels[l - 1].size());
    levels[l - 1].insert(levels[l - 1].end(), missing.begin(), missing.end());
    std::inplace_merge(levels[l - 1].begin(), levels[l - 1].begin() + middle, levels[l - 1].end(),
                       by_key);
  }
}

/// Appends the children of cells[begin, end) in their parents' order.
void append_children(std::vector<TreeCell>& cells, std::size_t begin, std::size_t end,
                     const std::vector<TreeCell>& level) {
  struct Place {
    CellKey key;
    std::uint32_t index;
  };
  std::vector<Place> parents;
  for (std::size_t c = begin; c < end; ++c) {
    parents.push_back({cells[c].key, static_cast<std::uint32_t>(c)});
  }
  std::sort(parents.begin(), parents.end(),
            [](const Place& a, const Place& b) { return a.key < b.key; });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order;  // parent, own index in level
  for (std::size_t n = 0; n < level.size(); ++n) {
    const auto found =
        std::lower_bound(parents.begin(), parents.end(), level[n].key.parent(),
                         [](const Place& a, const CellKey& key) { return a.key < key; });
    assert(found != parents.end() && found->key == level[n].key.parent());
    order.emplace_back(found->index, static_cast<std::uint32_t>(n));
  }
  std::sort(order.begin(), order.end());
  for (const auto& [parent, n] : order) {
    if (cells[parent].children++ == 0) {
      cells[parent].first_child = static_cast<std::uint32_t>(cells.size());
    }
    cells.push_back(level[n]);
  }
}

/// Finds Tree::errors: first how many levels each cell has one for, then what they are.
void add_errors(Tree& tree) {
  std::vector<std::uint8_t> levels(tree.cells.size(), 0);
  for (std::size_t c = tree.cells.size(); c-- > 0;) {
    const TreeCell& cell = tree.cells[c];
    for (std::uint32_t n = 0; n < cell.children; ++n)
      levels[c] = std::max(levels[c], static_cast<std::uint8_t>(levels[cell.first_child + n] + 1));
  }
  std::uint32_t count = 0;
  for (std::size_t c = 0; c < tree.cells.size(); ++c) {
    tree.cells[c].first_error = count;
    count += levels[c];
  }
  tree.errors.assign(count, 0.0f);
  for (std::size_t c = tree.cells.size(); c-- > 0;) {
    const TreeCell& cell = tree.cells[c];
    if (cell.children == 0) continue;
    float* errors = tree.errors.data() + cell.first_error;
    errors[0] = cell.error_m;
    for (std::uint32_t n = cell.first_child; n < cell.first_child + cell.children; ++n) {
      const auto below = tree.errors_of(n);
      for (std::size_t l = 0; l < below.size(); ++l)
        errors[l + 1] = std::max(errors[l + 1], below[l]);
    }
  }
}

}  // namespace

std::span<const float> Tree::errors_of(std::size_t cell) const {
  const std::size_t first = cells[cell].first_error;
  const std::size_t end = cell + 1 < cells.size() ? cells[cell + 1].first_error : errors.size();
  return std::span(errors).subspan(first, end - first);
}

std::span<const TreeCell> Tree::level(int l) const {
  const auto i = static_cast<std::size_t>(l);
  return std::span(cells).subspan(level_begin[i], level_begin[i + 1] - level_begin[i]);
}

Tree make_tree(const Header& header, std::span<const Node> nodes) {
  Tree tree;
  tree.lattice = header.lattice;
  tree.metric = {header.lattice.finest_level,
                 header.lattice.cell_bits,
                 header.edge_share,
                 header.partition,
                 0,
                 0};
  auto levels = cells_by_level(header.lattice, nodes);
  add_missing_parents(levels);
  std::size_t begin = 0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const std::size_t end = tree.cells.size();
    tree.level_begin[l] = static_cast<std::uint32_t>(end);
    if (l == 0) {
      tree.cells = std::move(levels[0]);
    } else {
      append_children(tree.cells, begin, end, levels[l]);
    }
    begin = end;
  }
  for (std::size_t l = levels.size(); l < tree.level_begin.size(); ++l) {
    tree.level_begin[l] = static_cast<std::uint32_t>(tree.cells.size());
  }
  for (std::size_t c = tree.cells.size(); c-- > 0;) {
    TreeCell& cell = tree.cells[c];
    for (std::uint32_t n = 0; n < cell.children; ++n) {
      const TreeCell& child = tree.cells[cell.first_child + n];
      cell.lowest = least(cell.lowest, child.lowest);
      cell.highest = most(cell.highest, child.highest);
      cell.error_m = std::max(cell.error_m, child.error_m);
    }
  }
  add_errors(tree);
  if (!tree.cells.empty()) {
    tree.metric.slab_low = 1 << 30, tree.metric.slab_high = -(1 << 30);
    for (const TreeCell& root : tree.level(0)) {
      tree.metric.slab_low = std::min(tree.metric.slab_low, root.lowest.z);
      tree.metric.slab_high = std::max(tree.metric.slab_high, root.highest.z);
    }
  }
  return tree;
}

}  // namespace cornice::hlod
