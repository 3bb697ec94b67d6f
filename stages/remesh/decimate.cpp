// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/decimate.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cornice::remesh {
namespace {

/// Of a length's square in the cost: where everything is flat, short edges go first, which keeps
/// triangles round.
constexpr float kShapeWeight = 1e-6f;
/// Largest turn of a triangle's normal in one collapse, as a cosine.
constexpr float kLeastTurnCosine = 0.5f;
/// Twice the area over the longest side's square: below this a new triangle is a sliver.
constexpr float kLeastShape = 0.08f;
/// Unless it was one before and has this share of its shape left. Where vertices lie on a heap,
/// each that goes leaves needles between the others, which only the last one takes with it.
constexpr float kNeedleLeft = 0.9f;
constexpr std::uint32_t kMostNeighbours = 14;
/// Of the candidates of a round, the cheaper part is tried: the others may be cheaper later.
constexpr double kTriedShare = 0.8;
/// A round that removes less than this share of the vertices is the last.
constexpr double kLeastProgress = 0.01;
/// Bits of a cost that do not count for the order: six of the mantissa do.
constexpr int kCostShift = 17;

/// The square of twice the area over the longest side's square.
float shape_sq(Vec3f ab, Vec3f ac, Vec3f normal2) {
  const Vec3f bc = ac - ab;
  const float longest_sq = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
  return longest_sq > 0.0f ? dot(normal2, normal2) / (longest_sq * longest_sq) : 0.0f;
}

/// Sum of a (n . x)^2 over planes, x relative to the quadric's own vertex.
struct Quadric {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  float bx = 0, by = 0, bz = 0, c = 0;
  float area = 0;

  void add_plane_through_origin(Vec3f n, float a) {
    xx += a * n.x * n.x, xy += a * n.x * n.y, xz += a * n.x * n.z;
    yy += a * n.y * n.y, yz += a * n.y * n.z, zz += a * n.z * n.z;
    area += a;
  }
  Vec3f matrix_times(Vec3f d) const {
    return {xx * d.x + xy * d.y + xz * d.z, xy * d.x + yy * d.y + yz * d.z,
            xz * d.x + yz * d.y + zz * d.z};
  }
  float at(Vec3f d) const {
    const Vec3f m = matrix_times(d);
    return dot(m, d) + 2.0f * (bx * d.x + by * d.y + bz * d.z) + c;
  }
  /// Adds another whose vertex lies at -d of this one's, that is, this one's lies at d of it.
  void add_moved(const Quadric& o, Vec3f d) {
    const Vec3f m = o.matrix_times(d);
    c += o.at(d);
    bx += o.bx + m.x, by += o.by + m.y, bz += o.bz + m.z;
    xx += o.xx, xy += o.xy, xz += o.xz, yy += o.yy, yz += o.yz, zz += o.zz;
    area += o.area;
  }
};

struct Candidate {
  float cost;
  std::uint32_t from;
  std::uint32_t to;
};

class Decimation {
 public:
  Decimation(const std::vector<Vec3f>& positions, Patch& patch, const Reference& input,
             const DecimateLimits& limits, Guard& guard)
      : positions_(positions),
        ids_(patch.vertices),
        fixed_(patch.fixed),
        triangles_(std::move(patch.triangles)),
        input_(input),
        limits_(limits),
        guard_(guard),
        quadrics_(positions.size()),
        stamp_(positions.size(), 0),
        state_(positions.size(), kChanged),
        refused_(positions.size(), -1.0f),
        best_(positions.size()),
        next_(positions.size(), kNoVertex),
        last_(positions.size(), 0) {
    for (const Triangle& t : triangles_) {
      const Vec3f n2 = normal2(t[0], t[1], t[2]);
      const float length = norm(n2);
      if (!(length > 0.0f)) continue;
      for (const std::uint32_t v : t) {
        quadrics_[v].add_plane_through_origin(n2 / length, 0.5f * length);
      }
    }
  }

  std::vector<Triangle> run() {
    for (;;) {
      link();
      find_candidates();
      sort_candidates();
      const std::size_t collapsed = collapse_round();
      drop_dead();
      if (static_cast<double>(collapsed) <= kLeastProgress * static_cast<double>(live_)) break;
    }
    return std::move(triangles_);
  }

 private:
  Vec3f normal2(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3f p = positions_[a];
    return cross(positions_[b] - p, positions_[c] - p);
  }

  /// Triangles of each vertex.
  void link() {
    first_.assign(positions_.size() + 1, 0);
    for (const Triangle& t : triangles_) {
      for (const std::uint32_t v : t) ++first_[v + 1];
    }
    live_ = 0;
    for (std::uint32_t v = 0; v < positions_.size(); ++v) {
      live_ += first_[v + 1] != 0;
      first_[v + 1] += first_[v];
      next_[v] = kNoVertex;
      last_[v] = v;
    }
    around_.resize(triangles_.size() * 3);
    at_.assign(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      for (const std::uint32_t v : triangles_[t]) around_[at_[v]++] = t;
    }
  }

  /// Calls visit(t) for the triangles at a vertex, among them those of vertices that it has taken
  /// in since the last link(); stops where visit returns false and returns false then.
  template <class Visit>
  bool each_triangle(std::uint32_t v, Visit&& visit) const {
    for (std::uint32_t part = v; part != kNoVertex; part = next_[part]) {
      for (std::uint32_t i = first_[part]; i < first_[part + 1]; ++i) {
        const std::uint32_t t = around_[i];
        if (triangles_[t][0] != triangles_[t][1] && !visit(t)) return false;
      }
    }
    return true;
  }

  /// The vertex that follows v in its triangle: round a closed ring, each neighbour once.
  std::uint32_t follower(std::uint32_t t, std::uint32_t v) const {
    const Triangle& c = triangles_[t];
    return c[0] == v ? c[1] : c[1] == v ? c[2] : c[0];
  }
  std::uint32_t leader(std::uint32_t t, std::uint32_t v) const {
    const Triangle& c = triangles_[t];
    return c[0] == v ? c[2] : c[1] == v ? c[0] : c[1];
  }

  void find_candidates() {
    candidates_.clear();
    for (std::uint32_t v = 0; v < positions_.size(); ++v) {
      if (fixed_[v] != 0 || first_[v] == first_[v + 1]) continue;
      if (state_[v] != kSame) find_best(v);
      if (best_[v].to != v) candidates_.push_back({best_[v].cost, v, best_[v].to});
      state_[v] = kSame;
    }
  }

  /// The neighbour onto which v goes at the least cost that has not been refused.
  void find_best(std::uint32_t v) {
    if (state_[v] != kRefused) refused_[v] = -1.0f;
    const float most_edge_sq = limits_.edge_m * limits_.edge_m;
    const Quadric& q = quadrics_[v];
    const float scale = q.area > 0.0f ? 1.0f / q.area : 0.0f;
    Best best{limits_.error_m * limits_.error_m, v};
    for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
      const std::uint32_t to = follower(around_[i], v);
      const Vec3f d = positions_[to] - positions_[v];
      const float edge_sq = dot(d, d);
      const float cost = std::max(0.0f, q.at(d)) * scale + kShapeWeight * edge_sq;
      if (cost < best.cost && cost > refused_[v] && edge_sq < most_edge_sq) best = {cost, to};
    }
    best_[v] = best;
  }

  /// By cost to a hundredth or two, by number where that is the same.
  void sort_candidates() {
    const auto bucket = [](float cost) { return std::bit_cast<std::uint32_t>(cost) >> kCostShift; };
    counts_.assign(
        (std::bit_cast<std::uint32_t>(limits_.error_m * limits_.error_m) >> kCostShift) + 2, 0);
    for (const Candidate& c : candidates_) ++counts_[bucket(c.cost) + 1];
    for (std::size_t b = 1; b < counts_.size(); ++b) counts_[b] += counts_[b - 1];
    sorted_.resize(candidates_.size());
    for (const Candidate& c : candidates_) sorted_[counts_[bucket(c.cost)]++] = c;
  }

  std::size_t collapse_round() {
    const auto tried =
        static_cast<std::size_t>(std::ceil(kTriedShare * static_cast<double>(sorted_.size())));
    std::size_t collapsed = 0;
    for (std::size_t i = 0; i < tried; ++i) {
      const auto [cost, from, to] = sorted_[i];
      if (state_[from] >= kGrown || state_[to] == kGone) continue;
      if (keeps_topology(from, to) && keeps_shape(from, to) && keeps_surface(from, to)) {
        collapse(from, to);
        ++collapsed;
      } else {
        refused_[from] = cost;
        state_[from] = std::max<std::uint8_t>(state_[from], kRefused);
      }
    }
    return collapsed;
  }

  /// Dey et al. 1999: the ends share no neighbours but those opposite their edge. Stricter where
  /// both may have triangles outside the patch.
  bool keeps_topology(std::uint32_t from, std::uint32_t to) {
    const std::uint32_t mark = next_stamp();
    std::uint32_t neighbours = 0;
    each_triangle(from, [&](std::uint32_t t) {
      stamp_[follower(t, from)] = mark;
      ++neighbours;
      return true;
    });
    std::uint32_t common = 0, neighbours_of_to = 0;
    each_triangle(to, [&](std::uint32_t t) {
      ++neighbours_of_to;
      for (const std::uint32_t n : {follower(t, to), leader(t, to)}) {
        if (stamp_[n] != mark) continue;
        ++common;
        stamp_[n] = mark - 1;  // counted; still told from those that are no neighbours of `from`
      }
      return true;
    });
    if (common != 2 || neighbours + neighbours_of_to > kMostNeighbours + 4) return false;
    if (neighbours < 3) return false;
    if (fixed_[to] == 0) return true;
    return each_triangle(from, [&](std::uint32_t t) {
      const std::uint32_t n = follower(t, from);
      return n == to || fixed_[n] == 0 || stamp_[n] != mark;
    });
  }

  std::uint32_t next_stamp() { return last_stamp_ += 2; }

  bool keeps_shape(std::uint32_t from, std::uint32_t to) const {
    const Vec3f p = positions_[to];
    const float most_edge_sq = limits_.edge_m * limits_.edge_m;
    return each_triangle(from, [&](std::uint32_t t) {
      const std::uint32_t b = follower(t, from), c = leader(t, from);
      if (b == to || c == to) return true;
      const Vec3f ab = positions_[b] - p, ac = positions_[c] - p, bc = ac - ab;
      if (std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)}) > most_edge_sq) return false;
      const Vec3f old_ab = positions_[b] - positions_[from],
                  old_ac = positions_[c] - positions_[from];
      const Vec3f before = cross(old_ab, old_ac), after = cross(ab, ac);
      const float shape = shape_sq(ab, ac, after);
      if (shape < kLeastShape * kLeastShape &&
          shape < kNeedleLeft * kNeedleLeft * shape_sq(old_ab, old_ac, before)) {
        return false;
      }
      const float after_sq = dot(after, after);
      const float turn = dot(before, after);
      // A triangle without area has no normal to keep.
      const float before_sq = dot(before, before);
      return !(before_sq > 0.0f &&
               (turn <= 0.0f ||
                turn * turn < kLeastTurnCosine * kLeastTurnCosine * before_sq * after_sq));
    });
  }

  bool keeps_surface(std::uint32_t from, std::uint32_t to) {
    guard_.begin();
    fresh_.clear();
    each_triangle(from, [&](std::uint32_t t) {
      guard_.take(t);
      const std::uint32_t b = follower(t, from), c = leader(t, from);
      if (b == to || c == to) return true;
      guard_.put(positions_[to], positions_[b], positions_[c]);
      fresh_.push_back(t);
      return true;
    });
    guard_.take_vertex(ids_[from]);
    return guard_.fits(input_.triangle_at(ids_[to]));
  }

  void collapse(std::uint32_t from, std::uint32_t to) {
    guard_.commit(fresh_);
    quadrics_[to].add_moved(quadrics_[from], positions_[to] - positions_[from]);
    each_triangle(from, [&](std::uint32_t number) {
      Triangle& t = triangles_[number];
      for (std::uint32_t& v : t) {
        if (state_[v] < kChanged) state_[v] = kChanged;
      }
      if (t[0] == to || t[1] == to || t[2] == to) {
        t = {0, 0, 0};
        return true;
      }
      for (std::uint32_t& v : t) {
        if (v == from) v = to;
      }
      return true;
    });
    state_[from] = kGone;
    state_[to] = kGrown;
    next_[last_[to]] = from;
    last_[to] = last_[from];
  }

  void drop_dead() {
    std::uint32_t kept = 0;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (triangles_[t][0] == triangles_[t][1]) continue;
      triangles_[kept] = triangles_[t];
      guard_.renumber(t, kept++);
    }
    triangles_.resize(kept);
  }

  const std::vector<Vec3f>& positions_;
  const std::vector<std::uint32_t>& ids_;
  const std::vector<std::uint8_t>& fixed_;
  std::vector<Triangle> triangles_;
  const Reference& input_;
  const DecimateLimits limits_;
  Guard& guard_;
  std::vector<std::uint32_t> fresh_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> stamp_;
  /// What has become of a vertex since its best neighbour was looked for.
  enum State : std::uint8_t { kSame, kRefused, kChanged, kGrown, kGone };
  std::vector<std::uint8_t> state_;
  std::vector<float> refused_;  ///< cost up to which neighbours have been refused
  struct Best {
    float cost;
    std::uint32_t to;  ///< the vertex itself: there is none
  };
  std::vector<Best> best_;
  static constexpr std::uint32_t kNoVertex = 0xffffffffu;
  std::vector<std::uint32_t> next_, last_;  ///< chain of vertices that one has taken in
  std::uint32_t last_stamp_ = 1;
  std::vector<std::uint32_t> first_, at_, around_;
  std::vector<Candidate> candidates_, sorted_;
  std::vector<std::uint32_t> counts_;
  std::size_t live_ = 0;
};

}  // namespace

std::vector<Triangle> decimate(const std::vector<Vec3f>& positions, Patch& patch,
                               const Reference& input, const DecimateLimits& limits, Guard& guard) {
  return Decimation(positions, patch, input, limits, guard).run();
}

}  // namespace cornice::remesh
