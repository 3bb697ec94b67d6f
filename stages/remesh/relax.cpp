// SPDX-License-Identifier: GPL-3.0-or-later
// Botsch, Kobbelt 2004, "A remeshing approach to multiresolution modeling"; sizes and weights after
// Dunyach, Vanderhaeghe, Barthe, Botsch 2013, "Adaptive remeshing for real-time mesh deformation".
#include "stages/remesh/relax.h"

#include <algorithm>
#include <cmath>

namespace cornice::remesh {
namespace {

constexpr float kSplitAbove = 4.0f / 3.0f;
constexpr float kCollapseBelow = 4.0f / 5.0f;
/// Cosines of the largest turn of a normal when a vertex vanishes, moves, or an edge turns.
constexpr float kCollapseTurn = 0.6f;
constexpr float kMoveTurn = 0.6f;
constexpr float kFlipTurn = 0.6f;
/// Twice the area over the longest side's square: 0.866 for equal sides; about the sine of the
/// smallest angle of thin triangles.
constexpr float kLeastShape = 0.1f;
constexpr int kSplitRounds = 4;
/// Cosine between the normals of a vertex and of a triangle at it from which on it is not smoothed.
constexpr float kSharp = 0.8f;
/// Share of its edge by which a new vertex may move onto the input.
constexpr float kSplitMove = 0.25f;
/// Least distance of a new vertex from the opposite corners, over the length of the edge that is
/// cut.
constexpr float kLeastCut = 0.02f;
/// Moves shorter than this share of the wanted length are not worth their checks.
constexpr float kLeastMove = 0.08f;
/// Way towards the middle of the neighbours in one step.
constexpr float kStep = 0.7f;

float shape(Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, bc = c - b;
  const float longest_sq = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
  return longest_sq > 0.0f ? norm(cross(ab, ac)) / longest_sq : 0.0f;
}

bool turned_too_far(Vec3f before, Vec3f after, float cosine) {
  const float d = dot(before, after);
  return d <= 0.0f || d * d < cosine * cosine * dot(before, before) * dot(after, after);
}

class Relaxation {
 public:
  Relaxation(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits)
      : patch_(patch),
        mesh_(patch.mesh),
        guard_(patch.guard),
        input_(input),
        limits_(limits),
        changed_(patch.mesh.triangle_count(), 1) {}

  void run() {
    split_long();
    collapse_short();
    for (int round = 0; round < limits_.rounds; ++round) {
      flip_edges();
      smooth();
    }
    flip_edges();
  }

 private:
  float wanted(std::uint32_t a, std::uint32_t b) const {
    return std::min(patch_.size[a], patch_.size[b]);
  }

  /// A place on the input near p, on a side that faces along `normal`. False where there is none
  /// within reach.
  bool project(Vec3f p, Vec3f normal, std::uint32_t hint, Vec3f& on,
               std::uint32_t& triangle) const {
    const float reach_sq = limits_.reach_m * limits_.reach_m;
    NearestPoint found = input_.walk(p, hint, 0.0f);
    if (found.distance_sq > reach_sq || dot(input_.tree().normal(found.triangle), normal) <= 0.0f) {
      NearestQuery query;
      query.guess = found.triangle;
      query.facing = normal;
      query.max_distance_sq = reach_sq;
      found = input_.tree().nearest(p, query);
    }
    if (!found.found()) return false;
    on = input_.tree().point(found);
    triangle = found.triangle;
    return true;
  }

  /// Longest first, and edges turned before new ones are cut: cutting whatever comes next makes
  /// fans of thin triangles without end.
  void split_long() {
    struct Long {
      float excess;
      std::uint32_t h, start, end;
    };
    std::vector<Long> edges;
    for (int round = 0; round < kSplitRounds; ++round) {
      edges.clear();
      for (std::uint32_t h = 0; h < mesh_.half_edge_count(); ++h) {
        if (!mesh_.alive(h) || mesh_.twin(h) == kNone || mesh_.twin(h) < h) continue;
        if (mesh_.frozen(h)) continue;
        const std::uint32_t a = mesh_.start(h), b = mesh_.end(h);
        const float excess = mesh_.length(h) / (kSplitAbove * wanted(a, b));
        if (excess > 1.0f) edges.push_back({excess, h, a, b});
      }
      if (edges.empty()) return;
      std::sort(edges.begin(), edges.end(), [](const Long& a, const Long& b) {
        return a.excess != b.excess ? a.excess > b.excess : a.h < b.h;
      });
      for (const Long& e : edges) {
        if (mesh_.start(e.h) == e.start && mesh_.end(e.h) == e.end && mesh_.twin(e.h) != kNone) {
          split(e.h);
        }
      }
      flip_edges();
    }
  }

  void split(std::uint32_t h) {
    const std::uint32_t g = mesh_.twin(h);
    const std::uint32_t a = mesh_.start(h), b = mesh_.end(h);
    const std::uint32_t c = mesh_.opposite(h), d = mesh_.opposite(g);
    const Vec3f middle = (mesh_.position(a) + mesh_.position(b)) * 0.5f;
    const Vec3f normal = normalized(mesh_.normal2(a, b, c) + mesh_.normal2(b, a, d));
    std::uint32_t triangle = patch_.hint[a];
    Vec3f at;
    if (!project(middle, normal, patch_.hint[a], at, triangle) ||
        norm(at - middle) > kSplitMove * mesh_.length(h) || !split_fits(h, at, normal, triangle)) {
      at = middle;
      begin_split(h, at);
      if (!guard_.fits_anyway()) return;
    }
    if (patch_.may_cut_at(h, at)) commit(patch_.cut(h, at, triangle));
  }

  /// Tells the guard of a split; the new triangles in the order of PatchMesh::split().
  void begin_split(std::uint32_t h, Vec3f at) {
    const std::uint32_t g = mesh_.twin(h);
    const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
    const Vec3f c = mesh_.position(mesh_.opposite(h)), d = mesh_.position(mesh_.opposite(g));
    guard_.begin();
    guard_.take(h / 3);
    guard_.take(g / 3);
    guard_.put(at, c, a);
    guard_.put(at, b, c);
    guard_.put(at, d, b);
    guard_.put(at, a, d);
  }

  bool split_fits(std::uint32_t h, Vec3f at, Vec3f normal, std::uint32_t triangle) {
    return split_stays_upright(h, at, normal) && guard_.fits(triangle);
  }

  /// Whether the new triangles keep about the normal of the old ones. Tells the guard of them.
  bool split_stays_upright(std::uint32_t h, Vec3f at, Vec3f normal) {
    const std::uint32_t g = mesh_.twin(h);
    const Vec3f corners[4] = {mesh_.position(mesh_.start(h)), mesh_.position(mesh_.opposite(g)),
                              mesh_.position(mesh_.end(h)), mesh_.position(mesh_.opposite(h))};
    for (int k = 0; k < 4; ++k) {
      const Vec3f after = cross(corners[k] - at, corners[(k + 1) % 4] - at);
      if (turned_too_far(normal, after, 0.5f * kMoveTurn)) return false;
    }
    begin_split(h, at);
    return true;
  }

  void collapse_short() {
    for (std::uint32_t h = 0; h < mesh_.half_edge_count(); ++h) {
      if (!mesh_.alive(h)) continue;
      const std::uint32_t a = mesh_.start(h), b = mesh_.end(h);
      if (mesh_.fixed(a) || mesh_.length(h) >= kCollapseBelow * wanted(a, b)) continue;
      if (!mesh_.may_collapse(h) || !collapse_keeps_surface(h)) continue;
      mesh_.collapse(h);
      commit(fresh_);
    }
  }

  /// Whether the triangles round start(h) may end at end(h) instead: none too long, too thin or
  /// turned, and the surface still near.
  bool collapse_keeps_surface(std::uint32_t h) {
    const std::uint32_t a = mesh_.start(h), b = mesh_.end(h);
    const Vec3f from = mesh_.position(a), to = mesh_.position(b);
    guard_.begin();
    fresh_.clear();
    const bool good = mesh_.each_out(a, [&](std::uint32_t out) {
      guard_.take(out / 3);
      const std::uint32_t c = mesh_.end(out), d = mesh_.opposite(out);
      if (c == b || d == b) return true;
      const Vec3f pc = mesh_.position(c), pd = mesh_.position(d);
      if (norm(pc - to) > kSplitAbove * wanted(b, c)) return false;
      const Vec3f after = cross(pc - to, pd - to);
      if (turned_too_far(cross(pc - from, pd - from), after, kCollapseTurn)) return false;
      if (shape(to, pc, pd) < kLeastShape) return false;
      guard_.put(to, pc, pd);
      fresh_.push_back(out / 3);
      return true;
    });
    return good && guard_.fits(patch_.hint[b]);
  }

  /// Edges next to what has changed since they were last looked at.
  void flip_edges() {
    for (int sweep = 0; sweep < 3; ++sweep) {
      std::size_t flipped = 0;
      looked_at_.swap(changed_);
      changed_.assign(mesh_.triangle_count(), 0);
      looked_at_.resize(mesh_.triangle_count(), 1);
      for (std::uint32_t h = 0; h < mesh_.half_edge_count(); ++h) {
        const std::uint32_t g = mesh_.alive(h) ? mesh_.twin(h) : kNone;
        if (g == kNone || g < h) continue;
        const bool is_news = (looked_at_[h / 3] | looked_at_[g / 3]) != 0;
        if (!is_news && (changed_[h / 3] | changed_[g / 3]) == 0) continue;
        if (!flip_helps(h) || !mesh_.may_flip(h) || !flip_fits(h)) continue;
        mesh_.flip(h);
        commit({h / 3, g / 3});
        ++flipped;
      }
      if (flipped == 0) break;
    }
  }

  /// Carries out at the guard what the mesh has done.
  void commit(const std::vector<std::uint32_t>& fresh) {
    guard_.commit(fresh);
    changed_.resize(mesh_.triangle_count(), 1);
    for (const std::uint32_t t : fresh) changed_[t] = 1;
  }

  /// Delaunay: the angles opposite the edge add up to more than 180 degrees.
  bool flip_helps(std::uint32_t h) const {
    const std::uint32_t g = mesh_.twin(h);
    const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
    const Vec3f c = mesh_.position(mesh_.opposite(h)), d = mesh_.position(mesh_.opposite(g));
    const Vec3f ca = a - c, cb = b - c, da = a - d, db = b - d;
    const float sine_c = norm(cross(ca, cb)), sine_d = norm(cross(da, db));
    const float cosine_c = dot(ca, cb), cosine_d = dot(da, db);
    // sin(c + d) < 0, by a margin that keeps rounding from turning an edge to and fro.
    const float sum = sine_c * cosine_d + cosine_c * sine_d;
    if (!(sum < -1e-3f * std::sqrt(dot(ca, ca) * dot(cb, cb) * dot(da, da) * dot(db, db)))) {
      return false;
    }
    const Vec3f n0 = cross(b - a, c - a), n1 = cross(a - b, d - b);
    const Vec3f m0 = cross(d - a, c - a), m1 = cross(b - d, c - d);
    const Vec3f before = n0 + n1;
    return !turned_too_far(before, m0, kFlipTurn) && !turned_too_far(before, m1, kFlipTurn);
  }

  bool flip_fits(std::uint32_t h) {
    const std::uint32_t g = mesh_.twin(h);
    const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
    const Vec3f c = mesh_.position(mesh_.opposite(h)), d = mesh_.position(mesh_.opposite(g));
    guard_.begin();
    guard_.take(h / 3);
    guard_.take(g / 3);
    guard_.put(c, a, d);
    guard_.put(c, d, b);
    return guard_.fits(patch_.hint[mesh_.opposite(h)]);
  }

  void smooth() {
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
      if (mesh_.vertex_alive(v) && !mesh_.fixed(v)) smooth(v);
    }
  }

  void smooth(std::uint32_t v) {
    const Vec3f p = mesh_.position(v);
    // Middle of the triangles' middles; small triangles where small ones are wanted weigh no less.
    Vec3f sum{}, normal{};
    float weights = 0.0f;
    mesh_.each_out(v, [&](std::uint32_t h) {
      const std::uint32_t b = mesh_.end(h), c = mesh_.opposite(h);
      const Vec3f pb = mesh_.position(b) - p, pc = mesh_.position(c) - p;
      const Vec3f n = cross(pb, pc);
      const float want = patch_.size[v] + patch_.size[b] + patch_.size[c];
      const float weight = norm(n) / (want * want);
      sum += (pb + pc) * (weight / 3.0f);
      weights += weight;
      normal += n;
      return true;
    });
    if (!(weights > 0.0f)) return;
    normal = normalized(normal);
    if (is_sharp(v, normal)) return;
    Vec3f step = sum / weights;
    step -= normal * dot(normal, step);
    Vec3f on;
    std::uint32_t triangle = 0;
    if (!project(p + step * kStep, normal, patch_.hint[v], on, triangle)) return;
    if (norm(on - p) < kLeastMove * patch_.size[v]) return;
    if (!move_keeps_surface(v, p, on) || !guard_.fits(triangle)) return;
    mesh_.move(v, on);
    commit(fresh_);
    patch_.hint[v] = triangle;
  }

  /// On a crest or in a corner: once off it, a vertex would slide away freely, step by step.
  bool is_sharp(std::uint32_t v, Vec3f normal) const {
    return !mesh_.each_out(v, [&](std::uint32_t h) {
      const Vec3f n = mesh_.normal2(v, mesh_.end(h), mesh_.opposite(h));
      return dot(n, normal) >= kSharp * norm(n);
    });
  }

  /// Whether the triangles round v stay upright and get no worse than they may be. Tells the guard.
  bool move_keeps_surface(std::uint32_t v, Vec3f from, Vec3f to) {
    float worst_before = 1.0f, worst_after = 1.0f;
    guard_.begin();
    fresh_.clear();
    const bool upright = mesh_.each_out(v, [&](std::uint32_t h) {
      const Vec3f b = mesh_.position(mesh_.end(h)), c = mesh_.position(mesh_.opposite(h));
      worst_before = std::min(worst_before, shape(from, b, c));
      worst_after = std::min(worst_after, shape(to, b, c));
      guard_.take(h / 3);
      guard_.put(to, b, c);
      fresh_.push_back(h / 3);
      return !turned_too_far(cross(b - from, c - from), cross(b - to, c - to), kMoveTurn);
    });
    return upright && (worst_after >= 0.4f || worst_after >= worst_before);
  }

  RelaxPatch& patch_;
  PatchMesh& mesh_;
  Guard& guard_;
  const Reference& input_;
  const RelaxLimits& limits_;
  /// Per triangle: since the last sweep of turns; before it, while that lasts.
  std::vector<std::uint8_t> changed_, looked_at_;
  std::vector<std::uint32_t> fresh_;  ///< numbers of the triangles that a change makes
};

}  // namespace

bool RelaxPatch::may_cut_at(std::uint32_t h, Vec3f at) const {
  const Vec3f c = mesh.position(mesh.opposite(h));
  const Vec3f d = mesh.position(mesh.opposite(mesh.twin(h)));
  return std::min(norm(c - at), norm(d - at)) >= kLeastCut * mesh.length(h);
}

std::vector<std::uint32_t> RelaxPatch::cut(std::uint32_t h, Vec3f at, std::uint32_t triangle) {
  const std::uint32_t g = mesh.twin(h);
  size.push_back(0.5f * (size[mesh.start(h)] + size[mesh.end(h)]));
  hint.push_back(triangle);
  mesh.split(h, at);
  const auto t2 = static_cast<std::uint32_t>(mesh.triangle_count()) - 2;
  return {h / 3, t2, g / 3, t2 + 1};
}

void relax(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits) {
  Relaxation(patch, input, limits).run();
}

}  // namespace cornice::remesh
