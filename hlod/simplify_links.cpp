// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify_links.h"

#include <algorithm>
#include <array>

#include "core/base/clones.h"

namespace cornice::hlod {
namespace {

/// Triangles that a link's own line holds while links are made; others are spilled.
constexpr std::uint32_t kHeld = 7;
/// Triangles that a loose link has more room for.
constexpr std::uint32_t kSpare = 8;

/// Goes round from triangle to triangle and writes the vertices in order, one more than triangles
/// where the fan is open. At most VertexLinks::kMostRound arcs.
Fan go_round(std::span<const Arc> arcs, std::uint32_t* order) {
  const std::size_t count = arcs.size();
  if (count == 0) return Fan::kNone;
  const auto following = [&](std::uint32_t at) {
    std::size_t found = count;
    for (std::size_t i = 0; i < count; ++i) found = arcs[i].from == at ? i : found;
    return found;
  };
  const auto go = [&](std::size_t start) {
    std::uint32_t passed = 1u << start;
    order[0] = arcs[start].from;
    order[1] = arcs[start].to;
    std::size_t steps = 1;
    for (; steps < count; ++steps) {
      const std::size_t next = following(order[steps]);
      if (next == count || (passed >> next & 1) != 0 || order[steps] == order[0]) break;
      passed |= 1u << next;
      order[steps + 1] = arcs[next].to;
    }
    return steps;
  };
  std::size_t steps = go(0);
  bool is_open = false;
  if (following(order[steps]) == count) {
    // The end of an open fan: its beginning is what no triangle leads to.
    is_open = true;
    for (std::size_t i = 0; i < count; ++i) {
      const bool led_to = std::any_of(arcs.begin(), arcs.end(),
                                      [&](const Arc& arc) { return arc.to == arcs[i].from; });
      if (!led_to) steps = go(i);
    }
  }
  if (steps != count) return Fan::kNone;
  if (is_open) return following(order[count]) == count ? Fan::kOpen : Fan::kNone;
  return order[count] == order[0] && count >= 3 ? Fan::kClosed : Fan::kNone;
}

/// The arcs of a link while links are made: where they begin, then where they end.
void take_held(const Link& link, std::uint32_t count, Arc* arcs) {
  for (std::uint32_t i = 0; i < count; ++i) arcs[i] = {link.at[i], link.at[kHeld + i]};
}

/// Puts the held arcs of a closed fan in order. False, and nothing done, where they are anything
/// else. What follows each arc is found for all of them at once; vertices that come twice lead to
/// any arc, and the checks find that out.
CORNICE_INLINE bool close(Link& link) {
  const std::uint32_t count = link.info;
  if (count < 3 || count > kHeld) return false;
  Int8 from, to, next{};
  load_lanes(link.at, from);
  load_lanes(link.at + kHeld, to);
  for (std::uint32_t i = 0; i < kHeld; ++i) {
    const auto name = i < count ? static_cast<std::int32_t>(link.at[i]) : -1;
    next |= (to == name) & static_cast<std::int32_t>(i + 1);
  }
  alignas(32) std::uint32_t froms[8], tos[8], follows[8], order[8];
  store_lanes(froms, from), store_lanes(tos, to), store_lanes(follows, next);
  store_lanes(order, Int8{} - 1);
  std::uint32_t passed = 0, at = 0;
  bool fails = false;
  for (std::uint32_t i = 0; i < count; ++i) {
    order[i] = froms[at];
    passed |= 1u << at;
    const std::uint32_t end = tos[at], following = follows[at];
    if (following == 0 || following > count) return false;
    at = following - 1;
    fails |= (froms[at] != end) | ((end == froms[0]) != (i + 1 == count));
  }
  if (fails || passed != (1u << count) - 1) return false;
  Int8 ordered;
  load_lanes(order, ordered);
  store_lanes(link.at, ordered);
  store_lanes(link.at + kHeld, Int8{} - 1);
  link.info = Link::kMark | Link::kClosed | count;
  return true;
}

}  // namespace

void VertexLinks::assign(std::size_t vertex_count, const std::vector<Triangle>& triangles) {
  assert(vertex_count < Link::kMark && "the highest bit is no part of an index");
  // One more for those who read a whole link from its middle.
  links_.resize(vertex_count + 1);
  for (Link& link : links_) link.info = 0;
  arcs_.clear();
  spilled_.clear();
  for (const Triangle& t : triangles) {
    add(t[0], {t[1], t[2]});
    add(t[1], {t[2], t[0]});
    add(t[2], {t[0], t[1]});
  }
  gather_spilled();
  put_in_order();
}

CORNICE_CLONES void VertexLinks::put_in_order() {
  for (std::uint32_t v = 0; v + 1 < links_.size(); ++v) {
    if (!close(links_[v])) put_in_order(v);
  }
}

inline void VertexLinks::add(std::uint32_t vertex, Arc arc) {
  Link& link = links_[vertex];
  const std::uint32_t count = link.info++;
  if (count < kHeld) [[likely]] {
    link.at[count] = arc.from;
    link.at[kHeld + count] = arc.to;
  } else {
    spilled_.push_back({vertex, arc});
  }
}

/// Makes loose links of those that were not held.
void VertexLinks::gather_spilled() {
  for (const Spilled& spilled : spilled_) {
    Link& link = links_[spilled.vertex];
    // A count still, whose bits are no flags: is_loose() would take 512 triangles for one.
    if ((link.info & Link::kMark) == 0) {
      const std::uint32_t count = link.info;
      const auto first = static_cast<std::uint32_t>(arcs_.size());
      arcs_.resize(arcs_.size() + count + kSpare);
      take_held(link, kHeld, arcs_.data() + first);
      link.at[0] = first;
      link.at[1] = kHeld;
      link.at[2] = count + kSpare;
      link.info = Link::kMark | Link::kLoose;
    }
    arcs_[link.at[0] + link.at[1]++] = spilled.arc;
  }
}

void VertexLinks::put_in_order(std::uint32_t vertex) {
  Link& link = links_[vertex];
  if (link.is_loose()) {
    tighten(vertex);
    return;
  }
  const std::uint32_t count = link.info;
  Arc arcs[kHeld];
  take_held(link, count, arcs);
  std::array<std::uint32_t, 2 * (kHeld + 1)> order;
  const Fan fan = go_round({arcs, count}, order.data());
  if (fan == Fan::kNone) {
    const auto first = static_cast<std::uint32_t>(arcs_.size());
    arcs_.resize(arcs_.size() + count + kSpare);
    std::copy_n(arcs, count, arcs_.data() + first);
    link.at[0] = first;
    link.at[1] = count;
    link.at[2] = count + kSpare;
    link.info = Link::kMark | Link::kLoose;
    return;
  }
  const std::uint32_t length = count + (fan == Fan::kOpen);
  for (std::uint32_t i = 0; i < Link::kMost; ++i) {
    link.at[i] = i < length ? order[std::min(i, kHeld)] : Link::kEmpty;
  }
  link.info = Link::kMark | (fan == Fan::kClosed ? Link::kClosed : 0) | length;
}

Fan VertexLinks::fan(std::uint32_t vertex) const {
  const Link& link = links_[vertex];
  if (!link.is_loose()) return link.is_closed() ? Fan::kClosed : Fan::kOpen;
  if (link.at[1] > kMostRound) return Fan::kNone;
  std::array<std::uint32_t, kMostRound + 1> order;
  return go_round(arcs_of(link), order.data());
}

bool VertexLinks::tighten(std::uint32_t vertex) {
  Link& link = links_[vertex];
  if (link.at[1] > Link::kMost) return false;
  std::array<std::uint32_t, Link::kMost + 1> order;
  const Fan fan = go_round(arcs_of(link), order.data());
  const std::uint32_t length = link.at[1] + (fan == Fan::kOpen);
  if (fan == Fan::kNone || length > Link::kMost) return false;
  for (std::uint32_t i = 0; i < Link::kMost; ++i) {
    link.at[i] = i < length ? order[i] : Link::kEmpty;
  }
  link.info = Link::kMark | (fan == Fan::kClosed ? Link::kClosed : 0) | length;
  return true;
}

bool VertexLinks::has_triangle(std::uint32_t vertex, std::uint32_t a, std::uint32_t b) const {
  const Link& link = links_[vertex];
  if (link.is_loose()) {
    return std::ranges::any_of(arcs_of(link), [&](const Arc& arc) {
      return (arc.from == a && arc.to == b) || (arc.from == b && arc.to == a);
    });
  }
  const std::uint32_t count = link.count();
  for (std::uint32_t i = 0; i < count; ++i) {
    if (i + 1 == count && !link.is_closed()) break;
    const std::uint32_t from = link.at[i], to = link.at[i + 1 == count ? 0 : i + 1];
    if ((from == a && to == b) || (from == b && to == a)) return true;
  }
  return false;
}

bool VertexLinks::has_any_loose(const Link& link, std::span<const std::uint32_t> others) const {
  return std::ranges::any_of(arcs_of(link), [&](const Arc& arc) {
    return std::ranges::any_of(
        others, [&](std::uint32_t other) { return arc.from == other || arc.to == other; });
  });
}

void VertexLinks::rename_loose(Link& link, std::uint32_t from, std::uint32_t to) {
  std::uint32_t kept = 0;
  const std::span<Arc> arcs = arcs_of(link);
  for (Arc arc : arcs) {
    arc.from = arc.from == from ? to : arc.from;
    arc.to = arc.to == from ? to : arc.to;
    if (arc.from != arc.to) arcs[kept++] = arc;
  }
  link.at[1] = kept;
}

void VertexLinks::loosen(std::uint32_t vertex) {
  Link& link = links_[vertex];
  const Link before = link;
  const auto arc_count = static_cast<std::uint32_t>(triangle_count(vertex));
  link.at[0] = static_cast<std::uint32_t>(arcs_.size());
  link.at[1] = arc_count;
  link.at[2] = arc_count + kSpare;
  link.info = Link::kMark | Link::kLoose;
  for (std::uint32_t i = 0; i < arc_count; ++i) {
    arcs_.push_back({before.at[i], before.at[i + 1 == before.count() ? 0 : i + 1]});
  }
  arcs_.resize(link.at[0] + link.at[2]);
}

void VertexLinks::merge_loose(std::uint32_t vertex, std::uint32_t gone,
                              std::span<const std::uint32_t> inserted, std::uint32_t before,
                              std::uint32_t after) {
  if (!links_[vertex].is_loose()) loosen(vertex);
  Link& link = links_[vertex];
  std::uint32_t kept = 0;
  const std::span<Arc> arcs = arcs_of(link);
  for (const Arc arc : arcs) {
    if (arc.from != gone && arc.to != gone) arcs[kept++] = arc;
  }
  link.at[1] = kept;
  const auto most = static_cast<std::uint32_t>(kept + inserted.size() + 1);
  if (most > link.at[2]) {
    const auto first = static_cast<std::uint32_t>(arcs_.size());
    link.at[2] = 2 * most;
    arcs_.resize(arcs_.size() + link.at[2]);
    std::copy_n(arcs_.data() + link.at[0], kept, arcs_.data() + first);
    link.at[0] = first;
  }
  std::uint32_t from = before;
  const auto go_on = [&](std::uint32_t to) {
    if (from != Link::kEmpty && to != Link::kEmpty) arcs_[link.at[0] + link.at[1]++] = {from, to};
    from = to;
  };
  for (const std::uint32_t to : inserted) go_on(to);
  go_on(after);
}

}  // namespace cornice::hlod
