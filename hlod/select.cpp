// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/select.h"

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
  for (const auto& plane : frustum.planes) {
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

std::vector<float> reaches(const Tree& tree, double scale) {
  std::vector<float> reach(tree.cells.size(), 0.0f);
  const double fine_steps = scale / tree.lattice.step(tree.lattice.finest_level);
  for (std::size_t c = tree.cells.size(); c-- > 0;) {
    const TreeCell& cell = tree.cells[c];
    if (cell.children == 0) continue;
    const int below = cell.key.level + 1;
    double value = 0.0;
    if (cell.error_m > 0.0f) {
      // Children are at their parents from this much before the radius on.
      value = double{cell.error_m} * fine_steps + 2.0 * tree.metric.share(below);
    }
    for (std::uint32_t child = cell.first_child; child < cell.first_child + cell.children;
         ++child) {
      if (reach[child] > 0.0f) {
        value = std::max(value, double{reach[child]} + tree.metric.gap(below));
      }
    }
    // Rounded up, so that the rule holds among the floats as well.
    reach[c] = std::nextafter(static_cast<float>(std::min(value, 0x1p29)), 0x1p30f);
    if (value == 0.0) reach[c] = 0.0f;
  }
  return reach;
}

Radii radii_for_eye(const Tree& tree, std::span<const float> reaches, FinePoint eye) {
  assert(reaches.size() == tree.cells.size());
  Radii radii;
  std::vector<std::uint32_t> stack(tree.level(0).size());
  for (std::uint32_t c = 0; c < stack.size(); ++c) stack[c] = c;
  while (!stack.empty()) {
    const std::uint32_t c = stack.back();
    stack.pop_back();
    const TreeCell& cell = tree.cells[c];
    const double reach = reaches[c];
    const double beyond = std::max(0.0, box_distance(cell, eye) - reach);
    // A child's demand is at least gap() less: its reach is, and its box lies inside this one.
    const double demand = reach - kFade * beyond;
    if (demand <= 0.0) continue;
    std::int64_t& radius = radii.of[at(cell.key.level)];
    radius = std::max(radius, static_cast<std::int64_t>(std::ceil(demand)));
    for (std::uint32_t child = 0; child < cell.children; ++child) {
      stack.push_back(cell.first_child + child);
    }
  }
  settle(radii, tree.metric);
  return radii;
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
                    const Frustum& frustum, Radii& radii) {
  assert(is_loaded.size() == tree.cells.size());
  std::vector<std::uint32_t> cells(tree.level(0).size()), below;
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
  frustum.planes.push_back({ahead.x, ahead.y, ahead.z, 0.0});
  const auto add = [&](Vec3d side, double full_deg) {
    const double half = 0.5 * full_deg * std::numbers::pi / 180.0;
    for (const double sign : {-1.0, 1.0}) {
      const Vec3d normal = std::sin(half) * ahead + sign * std::cos(half) * side;
      frustum.planes.push_back({normal.x, normal.y, normal.z, 0.0});
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
  sort_by_urgency(tree, eye, cells);
  return cells;
}

void sort_by_urgency(const Tree& tree, FinePoint eye, std::vector<std::uint32_t>& cells) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(cells.size());
  for (const std::uint32_t c : cells) {
    const auto level = static_cast<std::uint64_t>(tree.cells[c].key.level);
    const auto distance = static_cast<std::uint64_t>(cell_distance(tree, tree.cells[c], eye));
    order.emplace_back((level << 32) | distance, c);
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = order[i].second;
}

}  // namespace cornice::hlod
