// SPDX-License-Identifier: GPL-3.0-or-later
// Gumhold and Strasser 1998, "Real Time Compression of Triangle Mesh
// Connectivity" (the cut-border machine), with a stack of edges in place of the
// cut-border, so that any set of triangles will do: an edge that does not
// belong to exactly two triangles is taken for a border.
//
//        n            across the edge x-y of the front lies the triangle (y, x,
//        n); the front
//       / \           x-y becomes x-n, n-y. Known triangles lie below.
//      /   \          .
//   - x --- y -       .
#include "hlod/codec_walk.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "hlod/codec_fans.h"

namespace cornice::hlod {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// An edge of the front, the triangles that are known to its left. Its vertices
/// are written and read as one word: a processor waits where a load is wider
/// than the store it is served from.
class Gate {
 public:
  Gate(std::uint16_t from, std::uint16_t to, std::uint16_t opposite, std::uint32_t previous_gate,
       std::uint32_t next_gate)
      : previous(previous_gate),
        next(next_gate),
        word_(from | std::uint64_t{to} << 16 | std::uint64_t{opposite} << 32 | kOpen) {}
  std::uint16_t from() const { return static_cast<std::uint16_t>(word_); }
  std::uint16_t to() const { return static_cast<std::uint16_t>(word_ >> 16); }
  std::uint16_t opposite() const { return static_cast<std::uint16_t>(word_ >> 32); }
  bool is_open() const { return word_ >= kOpen; }
  void close() { word_ &= kOpen - 1; }

  std::uint32_t previous, next;

 private:
  static constexpr std::uint64_t kOpen = std::uint64_t{1} << 48;
  std::uint64_t word_;
};

/// Edges of known triangles in closed chains, and those that are still to be
/// crossed on a stack. A chain may name edges that are done; the links of every
/// gate are numbers of gates.
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
      if (gates_[gate].is_open()) return gate;
    }
    return kNone;
  }

  /// A triangle of its own; its gates are size() - 3 for a-b, then b-c, c-a.
  void start(const SmallTriangle& t) {
    const std::uint32_t g = size();
    add({t[0], t[1], t[2], g + 2, g + 1});
    add({t[1], t[2], t[0], g, g + 2});
    add({t[2], t[0], t[1], g + 1, g});
  }
  void close(std::uint32_t gate) { gates_[gate].close(); }
  /// kNew: new gates size() - 2 (x-n) and size() - 1 (n-y).
  void widen(std::uint32_t gate, std::uint16_t n) {
    Gate& old = gates_[gate];
    const std::uint16_t from = old.from(), to = old.to();
    const std::uint32_t previous = old.previous, next = old.next, g = size();
    old.close();
    gates_[previous].next = g;
    gates_[next].previous = g + 1;
    add({from, n, to, previous, g + 1});
    add({n, to, from, g, next});
  }
  /// kFar: the same, but the front touches itself at n, so that the chain is
  /// parted there (or two are joined): p-n, n-q of the chain become p-n, n-y
  /// and x-n, n-q.
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
    Gate& left = gates_[gate];
    Gate& right = gates_[left.next];
    left.close(), right.close();
    replace({left.from(), right.to(), left.to(), left.previous, right.next});
  }
  /// kPrevious: new gate size() - 1 (n-y) in place of two.
  void close_previous(std::uint32_t gate) {
    Gate& right = gates_[gate];
    Gate& left = gates_[right.previous];
    left.close(), right.close();
    replace({left.from(), right.to(), right.from(), left.previous, right.next});
  }
  void close_both(std::uint32_t gate) {
    Gate& middle = gates_[gate];
    Gate &left = gates_[middle.previous], &right = gates_[middle.next];
    const std::uint32_t before = left.previous, after = right.next;
    left.close(), middle.close(), right.close();
    gates_[before].next = after;
    gates_[after].previous = before;
  }

 private:
  void replace(const Gate& gate) {
    const std::uint32_t g = size();
    gates_[gate.previous].next = g;
    gates_[gate.next].previous = g;
    add(gate);
  }
  void add(const Gate& gate) {
    latest_[gate.from()] = size();
    stack_.push_back(size());
    gates_.push_back(gate);
  }

  std::vector<Gate> gates_;
  std::vector<std::uint32_t> latest_;  ///< the last gate that began at each vertex
  std::vector<std::uint32_t> stack_;
};

class Walker {
 public:
  Walker(std::span<const SmallTriangle> triangles, std::size_t vertex_count)
      : triangles_(triangles),
        fans_(triangles, vertex_count),
        front_(triangles.size(), vertex_count),
        number_(vertex_count, kNoNumber),
        is_done_(triangles.size(), 0) {
    result_.references.reserve(vertex_count);
    result_.order.reserve(vertex_count);
    result_.walk.steps.reserve(triangles.size() + triangles.size() / 8);
  }

  WalkResult run() {
    for (std::uint32_t first = 0; first < triangles_.size(); ++first) {
      if (is_done_[first]) continue;
      start(first);
      for (std::uint32_t gate = front_.pop(); gate != kNone && left_ > 0; gate = front_.pop()) {
        result_.walk.steps.push_back(cross(gate));
      }
    }
    for (std::uint32_t v = 0; v < number_.size(); ++v) {
      if (number_[v] == kNoNumber) add_alone(static_cast<std::uint16_t>(v));
    }
    return std::move(result_);
  }

 private:
  static constexpr std::uint16_t kNoNumber = 0xffff;

  std::uint16_t known() const { return static_cast<std::uint16_t>(result_.order.size()); }

  void add_vertex(std::uint16_t old, const SmallTriangle& references) {
    number_[old] = known();
    result_.order.push_back(old);
    result_.references.push_back(references);
  }
  void add_alone(std::uint16_t old) {
    const std::uint16_t before = known() == 0 ? std::uint16_t{0} : std::uint16_t(known() - 1);
    add_vertex(old, {before, before, before});
  }
  void name_far(std::uint16_t old) {
    if (number_[old] == kNoNumber) {
      result_.walk.far.push_back(0);
      add_alone(old);
    } else {
      result_.walk.far.push_back(static_cast<std::uint16_t>(known() - number_[old]));
    }
  }
  void take(std::uint32_t triangle) {
    is_done_[triangle] = 1;
    --left_;
  }

  void start(std::uint32_t t) {
    for (const std::uint16_t old : triangles_[t]) name_far(old);
    take(t);
    front_.start(triangles_[t]);
  }

  Step cross(std::uint32_t gate) {
    const Gate& g = front_[gate];
    const std::uint16_t x = g.from(), y = g.to();
    const EdgeFans::Found across = fans_.left_of(y, x);
    if (across.triangle == EdgeFans::kNothing || is_done_[across.triangle]) {
      front_.close(gate);
      return Step::kNothing;
    }
    take(across.triangle);
    const std::uint16_t n = across.vertex;
    const Gate &next = front_[g.next], &previous = front_[g.previous];
    bool right = next.is_open() && next.to() == n,
         left = previous.is_open() && previous.from() == n;
    if (fans_.lacks_edges()) {
      right = right && fans_.left_of(n, y).triangle != EdgeFans::kNothing;
      left = left && fans_.left_of(x, n).triangle != EdgeFans::kNothing;
    }
    if (right && left) return front_.close_both(gate), Step::kBoth;
    if (right) return front_.close_next(gate), Step::kNext;
    if (left) return front_.close_previous(gate), Step::kPrevious;
    if (number_[n] == kNoNumber) {
      add_vertex(n, {number_[x], number_[y], number_[g.opposite()]});
      front_.widen(gate, n);
      return Step::kNew;
    }
    name_far(n);
    front_.touch(gate, n);
    return Step::kFar;
  }

  std::span<const SmallTriangle> triangles_;
  EdgeFans fans_;
  Front front_;                         ///< vertices by their old numbers
  std::vector<std::uint16_t> number_;   ///< new number of each old vertex
  std::vector<std::uint16_t> is_done_;  ///< bytes could be any member's own
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
    const Gate& g = front_[gate];
    const std::uint16_t x = g.from(), y = g.to();
    std::uint16_t n = 0;
    switch (step) {
      case Step::kNothing:
        front_.close(gate);
        return true;
      case Step::kNew:
        if (known() == vertex_count_) return false;
        n = static_cast<std::uint16_t>(known());
        walked_.references.push_back({x, y, g.opposite()});
        front_.widen(gate, n);
        break;
      case Step::kNext:
        n = front_[g.next].to();
        front_.close_next(gate);
        break;
      case Step::kPrevious:
        n = front_[g.previous].from();
        front_.close_previous(gate);
        break;
      case Step::kBoth:
        n = front_[g.next].to();
        front_.close_both(gate);
        break;
      case Step::kFar:
        if (!read_far(n)) return false;
        front_.touch(gate, n);
        break;
      default:
        return false;
    }
    walked_.triangles.push_back({y, x, n});
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
