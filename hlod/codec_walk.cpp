// SPDX-License-Identifier: GPL-3.0-or-later
// Gumhold and Strasser 1998, "Real Time Compression of Triangle Mesh Connectivity" (the cut-border
// machine), with a stack of edges in place of the cut-border, so that any set of triangles will do:
// an edge that does not belong to exactly two triangles is taken for a border.
//
//        n            across the edge x-y of the front lies the triangle (y, x, n); the front
//       / \           x-y becomes x-n, n-y. Known triangles lie below.
//      /   \          .
//   - x --- y -       .
#include "hlod/codec_walk.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

namespace cornice::hlod {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// An edge of the front, the triangles that are known to its left.
struct Gate {
  std::uint16_t from, to, opposite;
  bool is_open;
  std::uint32_t previous, next;
};

/// Edges of known triangles in closed chains, and those that are still to be crossed on a stack.
/// A chain may name edges that are done; the links of every gate are numbers of gates.
class Front {
 public:
  Front(std::size_t triangle_count, std::size_t vertex_count) : latest_(vertex_count, kNone) {
    gates_.reserve(2 * triangle_count + 64);
    stack_.reserve(256);
  }
  const Gate& operator[](std::uint32_t gate) const { return gates_[gate]; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(gates_.size()); }

  /// The next edge to cross, or kNone.
  std::uint32_t pop() {
    while (!stack_.empty()) {
      const std::uint32_t gate = stack_.back();
      stack_.pop_back();
      if (gates_[gate].is_open) return gate;
    }
    return kNone;
  }

  /// A triangle of its own; its gates are size() - 3 for a-b, then b-c, c-a.
  void start(const SmallTriangle& t) {
    const std::uint32_t g = size();
    add({t[0], t[1], t[2], true, g + 2, g + 1});
    add({t[1], t[2], t[0], true, g, g + 2});
    add({t[2], t[0], t[1], true, g + 1, g});
  }
  void close(std::uint32_t gate) { gates_[gate].is_open = false; }
  /// kNew: new gates size() - 2 (x-n) and size() - 1 (n-y).
  void widen(std::uint32_t gate, std::uint16_t n) {
    const Gate old = gates_[gate];
    const std::uint32_t g = size();
    add({old.from, n, old.to, true, old.previous, g + 1});
    add({n, old.to, old.from, true, g, old.next});
    gates_[old.previous].next = g;
    gates_[old.next].previous = g + 1;
    close(gate);
  }
  /// kFar: the same, but the front touches itself at n, so that the chain is parted there (or two
  /// are joined): p-n, n-q of the chain become p-n, n-y and x-n, n-q.
  void touch(std::uint32_t gate, std::uint16_t n) {
    const std::uint32_t beyond = latest_[n];
    widen(gate, n);
    if (beyond == kNone) return;
    const std::uint32_t to_n = size() - 2, from_n = size() - 1;
    const std::uint32_t before = gates_[beyond].previous;
    gates_[to_n].next = beyond, gates_[beyond].previous = to_n;
    gates_[before].next = from_n, gates_[from_n].previous = before;
  }
  /// kNext: new gate size() - 1 (x-n) in place of two.
  void close_next(std::uint32_t gate) {
    const Gate old = gates_[gate];
    const Gate right = gates_[old.next];
    replace(old.previous, right.next, {old.from, right.to, old.to, true, 0, 0});
    close(gate), close(old.next);
  }
  /// kPrevious: new gate size() - 1 (n-y) in place of two.
  void close_previous(std::uint32_t gate) {
    const Gate old = gates_[gate];
    const Gate left = gates_[old.previous];
    replace(left.previous, old.next, {left.from, old.to, old.from, true, 0, 0});
    close(gate), close(old.previous);
  }
  void close_both(std::uint32_t gate) {
    const Gate old = gates_[gate];
    const std::uint32_t before = gates_[old.previous].previous, after = gates_[old.next].next;
    close(gate), close(old.previous), close(old.next);
    gates_[before].next = after;
    gates_[after].previous = before;
  }

 private:
  void replace(std::uint32_t before, std::uint32_t after, Gate gate) {
    const std::uint32_t g = size();
    gate.previous = before, gate.next = after;
    add(gate);
    gates_[before].next = g;
    gates_[after].previous = g;
  }
  void add(const Gate& gate) {
    latest_[gate.from] = size();
    stack_.push_back(size());
    gates_.push_back(gate);
  }

  std::vector<Gate> gates_;
  std::vector<std::uint32_t> latest_;  ///< the last gate that began at each vertex
  std::vector<std::uint32_t> stack_;
};

std::uint32_t next_of(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
std::uint32_t previous_of(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// Edges in the list of the lower of their two vertices, four at a time.
struct EdgeSlots {
  static constexpr std::uint32_t kCount = 4;
  static constexpr std::uint64_t kNobody = 0xffffffffffffffffu;  ///< four numbers of no vertex

  std::uint64_t highers = kNobody;                 ///< the other vertex of each
  std::array<std::uint32_t, kCount> half_edges{};  ///< the first of each; 1 added to twice that
                                                   ///< where it leads to the higher vertex
  std::array<std::uint8_t, kCount> users{};
  std::uint32_t count : 8 = 0;
  std::uint32_t more : 24 = 0;  ///< further slots of the vertex, 0: none

  /// The place of an edge, kCount where it is not here. A lane is 0 where its number is the one
  /// that is looked for, and the lowest such lane is found by borrowing from it.
  std::uint32_t find(std::uint16_t higher) const {
    constexpr std::uint64_t kOnes = 0x0001000100010001u;
    const std::uint64_t differences = highers ^ kOnes * higher;
    const std::uint64_t zeros = (differences - kOnes) & ~differences & kOnes << 15;
    return static_cast<std::uint32_t>(std::countr_zero(zeros)) / 16;
  }
};

/// Pairs half-edges as they come.
class TwinMatcher {
 public:
  TwinMatcher(std::size_t triangle_count, std::size_t vertex_count)
      : slots_(vertex_count), twin_(3 * triangle_count + 1, kNone) {}

  void add(std::uint32_t half_edge, std::uint16_t from, std::uint16_t to) {
    const std::uint32_t is_upward = from < to;
    const std::uint16_t higher = std::max(from, to);
    EdgeSlots* slots = &slots_[std::min(from, to)];
    std::uint32_t place = slots->find(higher);
    while (place == EdgeSlots::kCount && slots->count == EdgeSlots::kCount) {
      slots = further(slots);
      place = slots->find(higher);
    }
    // Whether it is the first or the second of its edge cannot be foretold: no branches.
    const bool is_new = place == EdgeSlots::kCount;
    place = is_new ? slots->count : place;
    const std::uint32_t first = is_new ? 2 * half_edge + is_upward : slots->half_edges[place];
    const std::uint32_t users = ++slots->users[place];
    slots->half_edges[place] = first;
    slots->highers ^= std::uint64_t{is_new ? higher ^ 0xffffu : 0u} << (16 * place);
    slots->count = (slots->count + is_new) & 0xffu;
    if (users > 2) return part(*slots, place);
    const bool is_pair = users == 2 && (first & 1) != is_upward;
    twin_[half_edge] = is_pair ? first / 2 : kNone;
    twin_[is_pair ? first / 2 : twin_.size() - 1] = half_edge;
  }
  std::vector<std::uint32_t> take() { return std::move(twin_); }

 private:
  /// More slots for the same vertex.
  EdgeSlots* further(EdgeSlots* slots) {
    if (slots->more == 0) {
      const std::size_t at = static_cast<std::size_t>(slots - slots_.data());
      const auto last = static_cast<std::uint32_t>(slots_.size());
      slots_.emplace_back();
      slots = &slots_[at];
      slots->more = last & 0xffffffu;
    }
    return &slots_[slots->more];
  }
  /// An edge of more than two triangles has no twins.
  void part(EdgeSlots& slots, std::uint32_t place) {
    slots.users[place] = 3;
    const std::uint32_t first = slots.half_edges[place] / 2;
    if (twin_[first] == kNone) return;
    twin_[twin_[first]] = kNone;
    twin_[first] = kNone;
  }

  std::vector<EdgeSlots> slots_;  ///< of each vertex, then what did not fit there
  std::vector<std::uint32_t> twin_;
};

/// The half-edge on the other side of each; kNone where an edge has not exactly one of each
/// direction.
std::vector<std::uint32_t> match_twins(std::span<const SmallTriangle> triangles,
                                       std::size_t vertex_count) {
  TwinMatcher matcher(triangles.size(), vertex_count);
  std::uint32_t half_edge = 0;
  for (const SmallTriangle& t : triangles) {
    matcher.add(half_edge++, t[0], t[1]);
    matcher.add(half_edge++, t[1], t[2]);
    matcher.add(half_edge++, t[2], t[0]);
  }
  return matcher.take();
}

class Walker {
 public:
  Walker(std::span<const SmallTriangle> triangles, std::size_t vertex_count)
      : triangles_(triangles),
        twins_(match_twins(triangles, vertex_count)),
        front_(triangles.size(), vertex_count),
        number_(vertex_count, kNone),
        is_done_(triangles.size(), 0) {
    result_.walked.triangles.reserve(triangles.size());
    result_.walked.references.reserve(vertex_count);
    result_.order.reserve(vertex_count);
    result_.walk.steps.reserve(triangles.size() + triangles.size() / 8);
    half_edges_.reserve(3 * triangles.size());
  }

  WalkResult run() {
    for (std::uint32_t first = 0; first < triangles_.size(); ++first) {
      if (is_done_[first]) continue;
      start(first);
      for (std::uint32_t gate = front_.pop(); gate != kNone && left_ > 0; gate = front_.pop()) {
        cross(gate);
      }
    }
    for (std::uint32_t v = 0; v < number_.size(); ++v) {
      if (number_[v] == kNone) add_alone(v);
    }
    return std::move(result_);
  }

 private:
  std::uint16_t corner(std::uint32_t h) const { return triangles_[h / 3][h % 3]; }
  std::uint16_t known() const { return static_cast<std::uint16_t>(result_.order.size()); }

  void add_vertex(std::uint32_t old, const SmallTriangle& references) {
    number_[old] = known();
    result_.order.push_back(static_cast<std::uint16_t>(old));
    result_.walked.references.push_back(references);
  }
  void add_alone(std::uint32_t old) {
    const std::uint16_t before = known() == 0 ? std::uint16_t{0} : std::uint16_t(known() - 1);
    add_vertex(old, {before, before, before});
  }
  void name_far(std::uint32_t old) {
    if (number_[old] == kNone) {
      result_.walk.far.push_back(0);
      add_alone(old);
    } else {
      result_.walk.far.push_back(static_cast<std::uint16_t>(known() - number_[old]));
    }
  }
  void add_triangle(std::uint32_t t, const SmallTriangle& corners) {
    is_done_[t] = 1;
    --left_;
    result_.walked.triangles.push_back(corners);
  }

  void start(std::uint32_t t) {
    SmallTriangle corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      name_far(triangles_[t][c]);
      corners[c] = static_cast<std::uint16_t>(number_[triangles_[t][c]]);
    }
    add_triangle(t, corners);
    front_.start(corners);
    half_edges_.insert(half_edges_.end(), {3 * t, 3 * t + 1, 3 * t + 2});
  }

  bool closes(std::uint32_t gate, std::uint32_t half_edge) const {
    return front_[gate].is_open && twins_[half_edge] == half_edges_[gate];
  }

  void cross(std::uint32_t gate) {
    const std::uint32_t across = twins_[half_edges_[gate]];
    if (across == kNone || is_done_[across / 3]) {
      result_.walk.steps.push_back(Step::kNothing);
      front_.close(gate);
      return;
    }
    const std::uint32_t to_n = next_of(across), from_n = previous_of(across);
    const bool right = closes(front_[gate].next, from_n);
    const bool left = closes(front_[gate].previous, to_n);
    const std::uint32_t old = corner(from_n);
    const Gate g = front_[gate];
    if (right && left) {
      result_.walk.steps.push_back(Step::kBoth);
      front_.close_both(gate);
    } else if (right) {
      result_.walk.steps.push_back(Step::kNext);
      front_.close_next(gate);
      half_edges_.push_back(to_n);
    } else if (left) {
      result_.walk.steps.push_back(Step::kPrevious);
      front_.close_previous(gate);
      half_edges_.push_back(from_n);
    } else {
      const bool is_new = number_[old] == kNone;
      result_.walk.steps.push_back(is_new ? Step::kNew : Step::kFar);
      if (is_new) {
        add_vertex(old, {g.from, g.to, g.opposite});
      } else {
        name_far(old);
      }
      const auto n = static_cast<std::uint16_t>(number_[old]);
      is_new ? front_.widen(gate, n) : front_.touch(gate, n);
      half_edges_.insert(half_edges_.end(), {to_n, from_n});
    }
    add_triangle(across / 3, {g.to, g.from, static_cast<std::uint16_t>(number_[old])});
  }

  std::span<const SmallTriangle> triangles_;
  std::vector<std::uint32_t> twins_;
  Front front_;
  std::vector<std::uint32_t> half_edges_;  ///< of each gate, on the known side
  std::vector<std::uint32_t> number_;      ///< new number of each old vertex
  std::vector<std::uint8_t> is_done_;
  std::size_t left_ = triangles_.size();
  WalkResult result_;
};

class Follower {
 public:
  Follower(const Walk& walk, std::size_t triangle_count, std::size_t vertex_count, Walked& walked)
      : walk_(walk),
        triangle_count_(triangle_count),
        vertex_count_(vertex_count),
        front_(triangle_count, vertex_count),
        walked_(walked) {
    walked_.triangles.clear(), walked_.references.clear();
    walked_.triangles.reserve(triangle_count);
    walked_.references.reserve(vertex_count);
  }

  bool run() {
    while (walked_.triangles.size() < triangle_count_) {
      const std::uint32_t gate = front_.pop();
      if (!(gate == kNone ? start() : cross(gate))) return false;
    }
    while (known() < vertex_count_) add_alone();
    return step_ == walk_.steps.size() && far_ == walk_.far.size();
  }

 private:
  std::size_t known() const { return walked_.references.size(); }
  void add_alone() {
    const auto before = static_cast<std::uint16_t>(known() == 0 ? 0 : known() - 1);
    walked_.references.push_back({before, before, before});
  }
  bool read_far(std::uint16_t& vertex) {
    if (far_ == walk_.far.size()) return false;
    const std::size_t back = walk_.far[far_++];
    if (back > known() || (back == 0 && known() == vertex_count_)) return false;
    vertex = static_cast<std::uint16_t>(known() - back);
    if (back == 0) add_alone();
    return true;
  }
  bool start() {
    SmallTriangle t{};
    if (!read_far(t[0]) || !read_far(t[1]) || !read_far(t[2])) return false;
    walked_.triangles.push_back(t);
    front_.start(t);
    return true;
  }
  bool cross(std::uint32_t gate) {
    if (step_ == walk_.steps.size()) return false;
    const Step step = walk_.steps[step_++];
    const Gate g = front_[gate];
    std::uint16_t n = 0;
    switch (step) {
      case Step::kNothing:
        front_.close(gate);
        return true;
      case Step::kNew:
        if (known() == vertex_count_) return false;
        n = static_cast<std::uint16_t>(known());
        walked_.references.push_back({g.from, g.to, g.opposite});
        front_.widen(gate, n);
        break;
      case Step::kNext:
        n = front_[g.next].to;
        front_.close_next(gate);
        break;
      case Step::kPrevious:
        n = front_[g.previous].from;
        front_.close_previous(gate);
        break;
      case Step::kBoth:
        n = front_[g.next].to;
        front_.close_both(gate);
        break;
      case Step::kFar:
        if (!read_far(n)) return false;
        front_.touch(gate, n);
        break;
      default:
        return false;
    }
    walked_.triangles.push_back({g.to, g.from, n});
    return true;
  }

  const Walk& walk_;
  std::size_t triangle_count_, vertex_count_;
  std::size_t step_ = 0, far_ = 0;
  Front front_;
  Walked& walked_;
};

}  // namespace

WalkResult walk_triangles(std::span<const SmallTriangle> triangles, std::size_t vertex_count) {
  assert(vertex_count <= 65535 && "indices have 16 bits");
  return Walker(triangles, vertex_count).run();
}

bool follow_walk(const Walk& walk, std::size_t triangle_count, std::size_t vertex_count,
                 Walked& walked) {
  return Follower(walk, triangle_count, vertex_count, walked).run();
}

}  // namespace cornice::hlod
