// SPDX-License-Identifier: GPL-3.0-or-later
// Which triangle lies at an edge: the half-edges that begin at each vertex,
// eight at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <tuple>
#include <vector>

#include "hlod/codec_walk.h"

namespace cornice::hlod {

/// Edges of any set of triangles. An edge that more than two triangles have, or
/// two in the same direction, or that ends where it begins, is not there.
class EdgeFans {
 public:
  /// Third corner and number of a triangle.
  struct Found {
    std::uint16_t vertex = 0;
    std::uint32_t triangle = kNothing;
  };
  static constexpr std::uint32_t kNothing = 0xffffffffu;

  EdgeFans(std::span<const SmallTriangle> triangles, std::size_t vertex_count)
      : next_(vertex_count, 0), last_(vertex_count), counts_(vertex_count, 0) {
    fans_.reserve(vertex_count + vertex_count / 4);
    fans_.resize(vertex_count);
    std::uint32_t number = 0;
    for (const SmallTriangle& t : triangles) {
      add(number, t[0], t[1], t[2]);
      add(number, t[1], t[2], t[0]);
      add(number, t[2], t[0], t[1]);
      ++number;
    }
    if (has_repeats()) drop_crowded();
  }

  /// The triangle to the left of the edge.
  Found left_of(std::uint16_t from, std::uint16_t to) const {
    for (std::uint32_t at = from;;) {
      const Fan& fan = fans_[at];
      const std::uint32_t lane = fan.find(to);
      if (lane < kLanes) return {fan.third[lane], fan.triangle[lane]};
      at = next_[at];
      if (at == 0) return {};
    }
  }
  /// Whether edges are missing that triangles have.
  bool lacks_edges() const { return lacks_edges_; }

 private:
  static constexpr std::uint32_t kLanes = 8;
  static constexpr std::uint16_t kNobody = 0xffff;  ///< the number of no vertex

  struct alignas(64) Fan {
    std::array<std::uint16_t, kLanes> to;  ///< where the half-edges end
    std::array<std::uint16_t, kLanes> third;
    std::array<std::uint32_t, kLanes> triangle;

    Fan() { to.fill(kNobody); }
    /// kLanes where it is not here. A lane of a word is 0 where its number is
    /// the one that is looked for, and the lowest such lane is found by
    /// borrowing from it.
    std::uint32_t find(std::uint16_t vertex) const {
      constexpr std::uint64_t kOnes = 0x0001000100010001u;
      std::array<std::uint64_t, 2> words;
      std::memcpy(words.data(), to.data(), sizeof words);
      const auto zeros = [&](std::uint64_t word) {
        const std::uint64_t difference = word ^ kOnes * vertex;
        return (difference - kOnes) & ~difference & kOnes << 15;
      };
      const std::uint64_t low = zeros(words[0]), high = zeros(words[1]);
      const std::uint64_t either = low != 0 ? low : high;
      return static_cast<std::uint32_t>(std::countr_zero(either)) / 16 + (low != 0 ? 0 : 4) +
             (either != 0 ? 0 : kLanes);
    }
  };

  void add(std::uint32_t triangle, std::uint16_t from, std::uint16_t to, std::uint16_t third) {
    const std::uint32_t count = counts_[from]++, lane = count % kLanes;
    Fan& fan = count < kLanes ? fans_[from] : further(from, count);
    fan.to[lane] = to;
    fan.third[lane] = third;
    fan.triangle[lane] = triangle;
  }
  /// The fan that takes the half-edge after the first `count` of a vertex.
  Fan& further(std::uint16_t from, std::uint32_t count) {
    if (count % kLanes == 0) {
      const auto made = static_cast<std::uint32_t>(fans_.size());
      next_[count == kLanes ? from : last_[from]] = made;
      last_[from] = made;
      fans_.emplace_back();
      next_.push_back(0);
    }
    return fans_[last_[from]];
  }

  /// Calls act(lane's end) for every half-edge of a vertex, and for some that
  /// are nobody's.
  template <class Act>
  void for_each_end(std::uint16_t from, const Act& act) {
    std::uint32_t at = from;
    do {
      for (std::uint16_t& to : fans_[at].to) act(to);
      at = next_[at];
    } while (at != 0);
  }

  /// Whether a vertex has two half-edges to the same one, or one to itself.
  bool has_repeats() {
    std::vector<std::uint16_t> latest(std::size_t{kNobody} + 1, kNobody);
    std::uint32_t repeats = 0;
    for (std::uint32_t v = 0; v < counts_.size(); ++v) {
      const auto from = static_cast<std::uint16_t>(v);
      latest[from] = from;
      for_each_end(from, [&](std::uint16_t to) {
        repeats |= static_cast<std::uint32_t>(latest[to] == from) & (to != kNobody);
        latest[to] = from;
      });
    }
    return repeats != 0;
  }

  void drop_crowded() {
    struct End {
      std::uint16_t low, high;
      std::uint16_t* to;
      bool is_upward;
    };
    lacks_edges_ = true;
    std::vector<End> ends;
    for (std::uint32_t v = 0; v < counts_.size(); ++v) {
      const auto from = static_cast<std::uint16_t>(v);
      for_each_end(from, [&](std::uint16_t& to) {
        if (to == kNobody) return;
        ends.push_back({std::min(from, to), std::max(from, to), &to, from < to});
      });
    }
    const auto edge = [](const End& e) { return std::tie(e.low, e.high); };
    std::sort(ends.begin(), ends.end(),
              [&](const End& a, const End& b) { return edge(a) < edge(b); });
    for (std::size_t begin = 0, end = 0; begin < ends.size(); begin = end) {
      std::array<std::size_t, 2> users{};
      for (end = begin; end < ends.size() && edge(ends[end]) == edge(ends[begin]); ++end) {
        ++users[ends[end].is_upward];
      }
      if (users[0] <= 1 && users[1] <= 1 && ends[begin].low != ends[begin].high) continue;
      for (std::size_t e = begin; e < end; ++e) *ends[e].to = kNobody;
    }
  }

  std::vector<Fan> fans_;              ///< of each vertex, then what did not fit there
  std::vector<std::uint32_t> next_;    ///< of each fan: where its vertex goes on, 0: nowhere
  std::vector<std::uint32_t> last_;    ///< of each vertex: its last fan, where it has several
  std::vector<std::uint32_t> counts_;  ///< of each vertex: its half-edges
  bool lacks_edges_ = false;
};

}  // namespace cornice::hlod
