// SPDX-License-Identifier: GPL-3.0-or-later
// Which vertices lie round a vertex, in order; changes as edges collapse.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/topology.h"
#include "hlod/lanes.h"

namespace cornice::hlod {

/// The vertices round one vertex v as its triangles name them: (v, at[0], at[1]), (v, at[1], at[2])
/// and so on; in a closed link (v, at[count - 1], at[0]), too. No vertex comes twice. A vertex
/// with more of them, or whose triangles form anything else than one fan, has a loose link: its
/// triangles in any order, elsewhere. One line of the cache.
struct alignas(64) Link {
  static constexpr std::uint32_t kMost = 15;
  /// In `info`; the first is always set, so that `info` is no vertex's index.
  static constexpr std::uint32_t kMark = 0x80000000u, kClosed = 0x100u, kLoose = 0x200u;
  static constexpr std::uint32_t kCount = 0xffu;
  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  std::uint32_t at[kMost];  ///< behind the last: kEmpty. Loose: first arc, count, capacity
  std::uint32_t info;

  std::uint32_t count() const { return info & kCount; }
  bool is_closed() const { return (info & kClosed) != 0; }
  bool is_loose() const { return (info & kLoose) != 0; }
};

/// What one triangle (vertex, from, to) adds to the link of a vertex.
struct Arc {
  std::uint32_t from, to;
};

/// What the triangles of a vertex form: nothing that is a surface, one open fan or a closed one.
enum class Fan : std::uint8_t { kNone, kOpen, kClosed };

/// The links of all vertices. Vertex indices are below 2^31.
class VertexLinks {
 public:
  static constexpr std::size_t kMostRound = 31;

  void assign(std::size_t vertex_count, const std::vector<Triangle>& triangles);

  const Link& of(std::uint32_t vertex) const { return links_[vertex]; }
  void prefetch(std::uint32_t vertex) const { __builtin_prefetch(links_.data() + vertex); }
  std::size_t triangle_count(std::uint32_t vertex) const {
    const Link& link = links_[vertex];
    if (link.is_loose()) return link.at[1];
    return link.count() - (link.count() != 0 && !link.is_closed());
  }
  /// Calls act(from, to) for each triangle (vertex, from, to).
  template <class Act>
  void for_each_arc(std::uint32_t vertex, const Act& act) const {
    const Link& link = links_[vertex];
    if (link.is_loose()) [[unlikely]] {
      for (const Arc& arc : arcs_of(link)) act(arc.from, arc.to);
      return;
    }
    const std::uint32_t count = link.count();
    for (std::uint32_t i = 0; i + 1 < count; ++i) act(link.at[i], link.at[i + 1]);
    if (link.is_closed()) act(link.at[count - 1], link.at[0]);
  }
  /// Of loose links found by going round; more than kMostRound triangles count as no fan.
  Fan fan(std::uint32_t vertex) const;
  /// Puts a loose link in order if it is short enough and one fan. Whether it did.
  bool tighten(std::uint32_t vertex);

  /// Whether one of a few vertices is in the link.
  bool has_any(std::uint32_t vertex, std::span<const std::uint32_t> others) const;
  /// Whether a triangle has the vertex and these two.
  bool has_triangle(std::uint32_t vertex, std::uint32_t a, std::uint32_t b) const;
  /// `from`, which goes, becomes `to`, which the link has not.
  void rename(std::uint32_t vertex, std::uint32_t from, std::uint32_t to);
  /// `from` becomes `to`, its neighbour in the link: the triangle of the two goes.
  void erase(std::uint32_t vertex, std::uint32_t from, std::uint32_t to);
  /// The vertex takes on what lay round `gone`, a neighbour: `inserted` is what comes in its place,
  /// in order, between `before` and `after`; kEmpty where nothing follows at that end. Behind
  /// `inserted` is readable memory for a link.
  void merge(std::uint32_t vertex, std::uint32_t gone, std::span<const std::uint32_t> inserted,
             std::uint32_t before, std::uint32_t after);

 private:
  void add(std::uint32_t vertex, Arc arc);
  void gather_spilled();
  void put_in_order();
  void put_in_order(std::uint32_t vertex);
  void loosen(std::uint32_t vertex);
  void merge_loose(std::uint32_t vertex, std::uint32_t gone,
                   std::span<const std::uint32_t> inserted, std::uint32_t before,
                   std::uint32_t after);
  bool has_any_loose(const Link& link, std::span<const std::uint32_t> others) const;
  void rename_loose(Link& link, std::uint32_t from, std::uint32_t to);
  std::span<Arc> arcs_of(const Link& link) { return {arcs_.data() + link.at[0], link.at[1]}; }
  std::span<const Arc> arcs_of(const Link& link) const {
    return {arcs_.data() + link.at[0], link.at[1]};
  }

  struct Spilled {
    std::uint32_t vertex;
    Arc arc;
  };
  std::vector<Link> links_;
  std::vector<Arc> arcs_;         ///< of loose links
  std::vector<Spilled> spilled_;  ///< while links are made
};

/// The place of a vertex in a link that has it.
CORNICE_INLINE std::uint32_t place_in(const Link& link, std::uint32_t vertex) {
  const auto name = static_cast<std::int32_t>(vertex);
  Int8 low, high;
  load_lanes(link.at, low);
  load_lanes(link.at + 8, high);
  return static_cast<std::uint32_t>(
      or_of_lanes(((low == name) & kLaneNumbers) | ((high == name) & (kLaneNumbers + 8))));
}

/// The places at which a link that is not loose has any of three vertices, as bits.
CORNICE_INLINE std::uint32_t places_in(const Link& link, const Triangle& names) {
  const auto a = static_cast<std::int32_t>(names[0]), b = static_cast<std::int32_t>(names[1]);
  const auto c = static_cast<std::int32_t>(names[2]);
  Int4 bits{}, place{1, 2, 4, 8};
  for (int i = 0; i < 4; ++i) {
    Int4 lanes;
    load_lanes(link.at + 4 * i, lanes);
    bits |= ((lanes == a) | (lanes == b) | (lanes == c)) & place;
    place <<= 4;
  }
  bits |= CORNICE_SHUFFLE4(bits, bits, 2, 3, 0, 1);
  bits |= CORNICE_SHUFFLE4(bits, bits, 1, 0, 3, 2);
  return static_cast<std::uint32_t>(bits[0]);
}
/// The first of some places, of which there is at least one.
inline std::uint32_t first_place(std::uint32_t places) {
  return static_cast<std::uint32_t>(__builtin_ctz(places));
}
/// Places with each one on; behind the last comes the first in a closed link, and nothing
/// in an open one.
inline std::uint32_t one_place_on(const Link& link, std::uint32_t places) {
  const std::uint32_t count = link.count();
  const std::uint32_t moved = places << 1, end = 1u << count;
  return (moved & (end - 1)) | (link.is_closed() ? moved >> count : 0);
}

CORNICE_INLINE bool VertexLinks::has_any(std::uint32_t vertex,
                                         std::span<const std::uint32_t> others) const {
  const Link& link = links_[vertex];
  if (link.is_loose()) [[unlikely]]
    return has_any_loose(link, others);
  Int8 low, high;
  load_lanes(link.at, low);
  load_lanes(link.at + 8, high);
  Int8 met{};
  for (const std::uint32_t other : others) {
    const auto name = static_cast<std::int32_t>(other);
    met |= (low == name) | (high == name);
  }
  return or_of_lanes(met) != 0;
}

CORNICE_INLINE void VertexLinks::rename(std::uint32_t vertex, std::uint32_t from,
                                        std::uint32_t to) {
  Link& link = links_[vertex];
  if (link.is_loose()) [[unlikely]]
    return rename_loose(link, from, to);
  const auto old_name = static_cast<std::int32_t>(from);
  const auto change = static_cast<std::int32_t>(from ^ to);
  for (std::uint32_t* const at : {link.at, link.at + 8}) {
    Int8 lanes;
    load_lanes(at, lanes);
    store_lanes(at, lanes ^ ((lanes == old_name) & change));
  }
}

CORNICE_INLINE void VertexLinks::erase(std::uint32_t vertex, std::uint32_t from, std::uint32_t to) {
  Link& link = links_[vertex];
  if (link.is_loose()) [[unlikely]]
    return rename_loose(link, from, to);
  const auto place = static_cast<std::int32_t>(place_in(link, from));
  Int8 low, high;
  load_lanes(link.at, low);
  load_lanes(link.at + 8, high);
  // Lanes before the place keep what they have, the others take what follows; the last but one is
  // empty then, the last counts.
  const Int8 low_on = CORNICE_SHUFFLE8(low, high, 1, 2, 3, 4, 5, 6, 7, 8);
  const Int8 high_on =
      CORNICE_SHUFFLE8(high, Int8{} - 1, 1, 2, 3, 4, 5, 6, 8, 7) + Int8{0, 0, 0, 0, 0, 0, 0, -1};
  store_lanes(link.at, kLaneNumbers < place ? low : low_on);
  store_lanes(link.at + 8, kLaneNumbers + 8 < place ? high : high_on);
}

CORNICE_INLINE void VertexLinks::merge(std::uint32_t vertex, std::uint32_t gone,
                                       std::span<const std::uint32_t> inserted,
                                       std::uint32_t before, std::uint32_t after) {
  Link& link = links_[vertex];
  const auto more = static_cast<std::uint32_t>(inserted.size());
  if (link.is_loose() || link.count() + more > Link::kMost + 1) [[unlikely]]
    return merge_loose(vertex, gone, inserted, before, after);
  const std::uint32_t place = place_in(link, gone);
  // Copies of fixed length, each over the rest of the one before; behind the last link is room.
  std::uint32_t room[48];
  Int8 low, high;
  load_lanes(link.at + place + 1, low);
  load_lanes(link.at + place + 9, high);
  std::memcpy(room, link.at, sizeof link);
  std::memcpy(room + place, inserted.data(), sizeof link);
  store_lanes(room + place + more, low);
  store_lanes(room + place + more + 8, high);
  const std::uint32_t count = link.count() + more - 1;
  const std::uint32_t info = (link.info & ~Link::kCount) | count;
  const auto wanted = static_cast<std::int32_t>(count);
  const Int8 none = Int8{} - 1;
  load_lanes(room, low);
  load_lanes(room + 8, high);
  store_lanes(link.at, kLaneNumbers < wanted ? low : none);
  store_lanes(link.at + 8, kLaneNumbers + 8 < wanted ? high : none);
  link.info = info;
}

}  // namespace cornice::hlod
