// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/select.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

namespace cornice::hlod {
namespace {

/// What lies outside of an interval, as a distance; 0 inside.
std::int32_t outside(std::int32_t x, std::int32_t low, std::int32_t high) {
  return std::max({0, low - x, x - high});
}

std::int32_t box_distance(const TreeCell& cell, FinePoint eye) {
  return std::max({outside(eye.x, cell.lowest.x, cell.highest.x),
                   outside(eye.y, cell.lowest.y, cell.highest.y),
                   outside(eye.z, cell.lowest.z, cell.highest.z)});
}

std::size_t at(int level) { return static_cast<std::size_t>(level); }

/// How much faster than the eye a radius may fall once the eye has left a cell's reach.
constexpr double kFade = 2.0;

bool is_drawn(const Tree& tree, const Radii& radii, const TreeCell& cell, FinePoint eye) {
  return cell.children == 0 || cell_distance(tree, cell, eye) >= radii.of[at(cell.key.level)];
}

bool is_visible(const TreeCell& cell, FinePoint eye, const Frustum& frustum) {
  for (const auto& plane : frustum.planes()) {
    // The corner that lies furthest along the plane's normal.
    const auto corner = [&](double normal, std::int32_t low, std::int32_t high, std::int32_t from) {
      return normal * (static_cast<double>(normal > 0.0 ? high : low) - from);
    };
    if (corner(plane[0], cell.lowest.x, cell.highest.x, eye.x) +
            corner(plane[1], cell.lowest.y, cell.highest.y, eye.y) +
            corner(plane[2], cell.lowest.z, cell.highest.z, eye.z) + plane[3] <
        0.0) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::int32_t cell_distance(const Tree& tree, const TreeCell& cell, FinePoint eye) {
  const Metric& m = tree.metric;
  const std::int32_t side = m.side(cell.key.level);
  const auto along = [&](std::int32_t x, std::int32_t index) {
    const std::int32_t low = index * side;
    return outside(x, low, low + side);
  };
  const std::int32_t vertical =
      m.partition == Partition::kOctree ? along(eye.z, cell.key.k) : slab_distance(eye, m);
  return std::max({along(eye.x, cell.key.i), along(eye.y, cell.key.j), vertical});
}

double error_scale(double error_pixels, double viewport_pixels, double field_of_view_deg) {
  const double half = 0.5 * field_of_view_deg * std::numbers::pi / 180.0;
  return viewport_pixels / (2.0 * std::tan(half) * error_pixels);
}

namespace {

/// Raises radii to what cells ask for.
class Demands {
 public:
  Demands(const Tree& tree, double scale, FinePoint eye)
      : tree_(tree), fine_steps_(scale / tree.lattice.step(tree.lattice.finest_level)), eye_(eye) {}

  void ask(std::uint32_t c) { ask(c, box_distance(tree_.cells[c], eye_)); }

  /// Settled.
  Radii take() {
    settle(radii_, tree_.metric);
    return radii_;
  }

 private:
  using Reaches = std::array<double, kLevelLimit>;

  /// Up to where an error asks for children of its level; 0: nowhere.
  double reach(float error_m, int level) const {
    if (error_m <= 0.0f) return 0.0;
    // Children are at their parents from this much before the radius on.
    return std::min(double{error_m} * fine_steps_ + 2.0 * tree_.metric.share(level + 1), 0x1p29);
  }

  static double demand(double reach, double distance) {
    return reach - kFade * std::max(0.0, distance - reach);
  }

  /// By level from the cell's own on: how far what is in it reaches at most. Never below the next
  /// level's plus gap(), so radii obey the rule by themselves, and none jumps when a finer one
  /// comes or goes. Whether any of them has a say.
  bool find_reaches(std::uint32_t c, double distance, Reaches& reaches) const {
    const int own_level = tree_.cells[c].key.level;
    const auto errors = tree_.errors_of(c);
    double below = 0.0;
    bool has_a_say = false;
    for (std::size_t l = errors.size(); l-- > 0;) {
      const int level = own_level + static_cast<int>(l);
      double value = reach(errors[l], level);
      if (below > 0.0) value = std::max(value, below + tree_.metric.gap(level + 1));
      reaches[l] = below = value;
      has_a_say = has_a_say || demand(value, distance) > static_cast<double>(radii_.of[at(level)]);
    }
    return has_a_say;
  }

  void ask(std::uint32_t c, double distance) {
    Reaches reaches;
    if (!find_reaches(c, distance, reaches)) return;
    const TreeCell& cell = tree_.cells[c];
    const double own = std::ceil(demand(reaches[0], distance));
    std::int64_t& radius = radii_.of[at(cell.key.level)];
    radius = std::max(radius, static_cast<std::int64_t>(own));
    // Those that ask for most first: they leave the others without a say.
    struct Child {
      double demand = 0.0, distance = 0.0;
      std::uint32_t index = 0;
    };
    std::array<Child, 8> children;
    std::size_t count = 0;
    for (std::uint32_t n = 0; n < cell.children; ++n) {
      const std::uint32_t index = cell.first_child + n;
      const TreeCell& child = tree_.cells[index];
      if (child.children == 0) continue;
      const double far = box_distance(child, eye_);
      const double asked = demand(reach(child.error_m, child.key.level), far);
      std::size_t place = count++;
      for (; place > 0 && children[place - 1].demand < asked; --place)
        children[place] = children[place - 1];
      children[place] = {asked, far, index};
    }
    for (std::size_t n = 0; n < count; ++n) ask(children[n].index, children[n].distance);
  }

  const Tree& tree_;
  double fine_steps_;
  FinePoint eye_;
  Radii radii_;
};

}  // namespace

Radii radii_for_eye(const Tree& tree, double scale, FinePoint eye) {
  Demands demands(tree, scale, eye);
  for (std::uint32_t root = 0; root < tree.level(0).size(); ++root) demands.ask(root);
  return demands.take();
}

Radii radii_by_factor(const Metric& metric, double factor) {
  const double least = 1.0 + 3.0 * metric.edge_share + 1.0 / 16.0;
  Radii radii;
  for (int l = 0; l < metric.finest_level; ++l) {
    radii.of[at(l)] = std::llround(std::max(factor, least) * metric.side(l));
  }
  // Shares are rounded up, so the least factor may lack a step or two at fine levels.
  for (int l = metric.finest_level - 1; l > 0; --l) {
    radii.of[at(l) - 1] = std::max(radii.of[at(l) - 1], radii.of[at(l)] + metric.gap(l));
  }
  settle(radii, metric);
  return radii;
}

void settle(Radii& radii, const Metric& metric) {
  // Beyond everything that can be seen from an eye.
  radii.of[0] = std::min(radii.of[0], std::int64_t{1} << 30);
  if (metric.finest_level == 0) radii.of[0] = std::min<std::int64_t>(radii.of[0], 0);
  for (int l = 1; l <= metric.finest_level; ++l) {
    const std::int64_t most = radii.of[at(l) - 1] - metric.gap(l);
    const std::int64_t wanted =
        l == metric.finest_level ? 0 : std::max<std::int64_t>(radii.of[at(l)], 0);
    radii.of[at(l)] = std::min(most, wanted);
  }
}

bool obeys_rule(const Radii& radii, const Metric& metric) {
  for (int l = 1; l <= metric.finest_level; ++l) {
    if (radii.of[at(l) - 1] < radii.of[at(l)] + metric.gap(l)) return false;
  }
  return radii.of[at(metric.finest_level)] <= 0;
}

Radii scaled(const Radii& radii, double share, const Metric& metric) {
  Radii result = radii;
  for (std::int64_t& radius : result.of) {
    if (radius > 0) radius = std::llround(share * static_cast<double>(radius));
  }
  settle(result, metric);
  return result;
}

Radii blended(const Radii& from, const Radii& to, double share, const Metric& metric) {
  Radii result;
  for (std::size_t l = 0; l < result.of.size(); ++l) {
    const double way = static_cast<double>(to.of[l] - from.of[l]);
    result.of[l] = from.of[l] + std::llround(share * way);
  }
  settle(result, metric);
  return result;
}

void hold_to_loaded(const Tree& tree, std::span<const std::uint8_t> is_loaded, FinePoint eye,
                    const Frustum& frustum, Radii& radii, WalkMemory& memory) {
  assert(is_loaded.size() == tree.cells.size());
  auto& [cells, below] = memory;
  cells.resize(tree.level(0).size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) cells[c] = c;
  for (int l = 0; l < tree.metric.finest_level; ++l) {
    std::int64_t& radius = radii.of[at(l)];
    for (const std::uint32_t c : cells) {
      const TreeCell& cell = tree.cells[c];
      if (!is_visible(cell, eye, frustum)) continue;
      const auto children = is_loaded.subspan(cell.first_child, cell.children);
      if (std::find(children.begin(), children.end(), 0) == children.end()) continue;
      radius = std::min<std::int64_t>(radius, cell_distance(tree, cell, eye));
    }
    below.clear();
    for (const std::uint32_t c : cells) {
      const TreeCell& cell = tree.cells[c];
      // What is below an invisible cell cannot be seen either.
      if (is_drawn(tree, radii, cell, eye) || !is_visible(cell, eye, frustum)) continue;
      for (std::uint32_t n = 0; n < cell.children; ++n) below.push_back(cell.first_child + n);
    }
    cells.swap(below);
    std::int64_t& next = radii.of[at(l) + 1];
    next = std::min(next, radius - tree.metric.gap(l + 1));
  }
  settle(radii, tree.metric);
}

Frustum make_frustum(Vec3d forward, Vec3d up, double horizontal_deg, double vertical_deg) {
  const Vec3d ahead = normalized(forward), right = normalized(cross(ahead, up));
  const Vec3d above = cross(right, ahead);
  Frustum frustum;
  // Without it, a large box behind the eye that reaches both to the left and to the right is seen.
  frustum.add({ahead.x, ahead.y, ahead.z, 0.0});
  const auto add = [&](Vec3d side, double full_deg) {
    const double half = 0.5 * full_deg * std::numbers::pi / 180.0;
    for (const double sign : {-1.0, 1.0}) {
      const Vec3d normal = std::sin(half) * ahead + sign * std::cos(half) * side;
      frustum.add({normal.x, normal.y, normal.z, 0.0});
    }
  };
  add(right, horizontal_deg);
  add(above, vertical_deg);
  return frustum;
}

void select(const Tree& tree, const Radii& radii, FinePoint eye, const Frustum& frustum,
            Selection& selection) {
  selection.cells.clear(), selection.stack.clear();
  selection.triangles = 0;
  for (auto c = static_cast<std::uint32_t>(tree.level(0).size()); c-- > 0;) {
    selection.stack.push_back(c);
  }
  while (!selection.stack.empty()) {
    const std::uint32_t c = selection.stack.back();
    selection.stack.pop_back();
    const TreeCell& cell = tree.cells[c];
    if (!is_visible(cell, eye, frustum)) continue;
    if (!is_drawn(tree, radii, cell, eye)) {
      for (std::uint32_t n = cell.children; n-- > 0;) {
        selection.stack.push_back(cell.first_child + n);
      }
      continue;
    }
    if (cell.parts == 0) continue;
    selection.cells.push_back(c);
    selection.triangles += cell.triangles;
  }
}

double share_for_budget(const Tree& tree, const Radii& radii, FinePoint eye, const Frustum& frustum,
                        std::uint64_t budget, Selection& scratch) {
  const auto fits = [&](int share) {
    select(tree, scaled(radii, share / 256.0, tree.metric), eye, frustum, scratch);
    return scratch.triangles <= budget;
  };
  if (fits(256)) return 1.0;
  int low = 0, high = 256;  // what does not fit at `low` does not fit anywhere
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (fits(middle) ? low : high) = middle;
  }
  return low / 256.0;
}

void needed_cells(const Tree& tree, const Radii& radii, FinePoint eye, const Frustum& frustum,
                  std::vector<std::uint32_t>& cells) {
  cells.resize(tree.level(0).size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) cells[c] = c;
  // The list itself is the queue of a walk from level to level.
  for (std::size_t next = 0; next < cells.size(); ++next) {
    const TreeCell& cell = tree.cells[cells[next]];
    if (is_drawn(tree, radii, cell, eye)) continue;
    // All children or none: a parent gives way to all of them at once, seen or not.
    if (!is_visible(cell, eye, frustum)) continue;
    for (std::uint32_t n = 0; n < cell.children; ++n) cells.push_back(cell.first_child + n);
  }
  std::erase_if(cells, [&](std::uint32_t c) { return tree.cells[c].parts == 0; });
}

std::vector<std::uint32_t> wanted_cells(const Tree& tree, std::span<const std::uint8_t> is_loaded,
                                        const Radii& radii, FinePoint eye, const Frustum& frustum) {
  std::vector<std::uint32_t> cells;
  needed_cells(tree, radii, eye, frustum, cells);
  std::erase_if(cells, [&](std::uint32_t c) { return is_loaded[c] != 0; });
  UrgencyMemory memory;
  keep_most_urgent(tree, eye, cells.size(), cells, memory);
  return cells;
}

void keep_most_urgent(const Tree& tree, FinePoint eye, std::size_t most,
                      std::vector<std::uint32_t>& cells, UrgencyMemory& memory) {
  auto& order = memory.order;
  order.clear();
  for (const std::uint32_t c : cells) {
    const auto level = static_cast<std::uint64_t>(tree.cells[c].key.level);
    const auto distance = static_cast<std::uint64_t>(cell_distance(tree, tree.cells[c], eye));
    order.emplace_back((level << 32) | distance, c);
  }
  const std::size_t count = std::min(most, order.size());
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(count);
  if (count < order.size()) std::nth_element(order.begin(), end, order.end());
  std::sort(order.begin(), end);
  cells.resize(count);
  for (std::size_t i = 0; i < count; ++i) cells[i] = order[i].second;
}

}  // namespace cornice::hlod
