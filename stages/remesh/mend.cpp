// SPDX-License-Identifier: GPL-3.0-or-later
// Local repair: of the few changes that are possible at a triangle that leaves the bound, the first
// one that keeps it everywhere.
#include <algorithm>
#include <array>
#include <cmath>

#include "stages/remesh/relax.h"

namespace cornice::remesh {
namespace {

/// Of an offence's distance: what a change must reach that does not keep the bound.
constexpr float kNearer = 0.95f;
/// Square of the bound's share up to which a place counts as one that a triangle should reach.
constexpr float kAbout = 1.6f;

/// Of the bound: how far a vertex must move.
constexpr float kLeastMove = 0.1f;
/// Sine of the smallest angle to ask for: 22 degrees.
constexpr float kRoundSine = 0.37f;

/// Sine of a triangle's smallest angle.
float least_sine(Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, bc = c - b;
  const float sides_sq[3] = {dot(ab, ab), dot(ac, ac), dot(bc, bc)};
  const float shortest_sq = std::max(*std::min_element(sides_sq, sides_sq + 3), 1e-12f);
  const float longer_sq = sides_sq[0] * sides_sq[1] * sides_sq[2] / shortest_sq;
  return longer_sq > 0.0f ? norm(cross(ab, ac)) / std::sqrt(longer_sq) : 0.0f;
}

class Mending {
 public:
  Mending(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Vec3f>& places)
      : patch_(patch),
        mesh_(patch.mesh),
        guard_(patch.guard),
        input_(input),
        limits_(limits),
        places_(places),
        changed_(patch.mesh.triangle_count(), 0) {}

  void run(const std::vector<Offence>& offences) {
    for (const Offence& o : offences) {
      // What a change nearby has made of it is told by the next measurement.
      if (mesh_.triangle_alive(o.triangle) && changed_[o.triangle] == 0) mend(o);
    }
  }

 private:
  void mend(const Offence& o) {
    const std::uint32_t first = 3 * o.triangle;
    std::array<std::uint32_t, 3> sides{first, first + 1, first + 2};
    const auto distance_sq = [&](std::uint32_t h) {
      const Vec3f p = o.must_reach ? o.through : o.place;
      return nearest_on_triangle(p, mesh_.position(mesh_.start(h)), mesh_.position(mesh_.end(h)),
                                 mesh_.position(mesh_.end(h)))
          .distance_sq;
    };
    std::stable_sort(sides.begin(), sides.end(), [&](std::uint32_t a, std::uint32_t b) {
      return distance_sq(a) < distance_sq(b);
    });
    guard_.bound_by(limits_.guard.error_m);
    // What keeps the bound at the places looked at has not helped so far.
    if (limits_.insists && o.distance_m > limits_.guard.error_m && halve(sides, o)) return;
    // Round triangles where that is possible, any else.
    least_sine_ = kRoundSine;
    if (try_all(sides, o)) return;
    least_sine_ = 0.0f;
    if (try_all(sides, o)) return;
    // Where several places of one fold offend, no change mends all: be it nearer at least.
    const float nearer = kNearer * o.distance_m;
    guard_.bound_by(std::max(nearer, limits_.guard.error_m));
    if (nearer > limits_.guard.error_m && try_all(sides, o)) return;
    halve(sides, o);
  }

  bool try_all(const std::array<std::uint32_t, 3>& sides, const Offence& o) {
    for (const std::uint32_t h : sides) {
      if (may_split(h) && split(h, o, o.through, o.input_triangle)) return true;
    }
    for (const std::uint32_t h : sides) {
      if (mesh_.may_flip(h) && flip(h, o)) return true;
    }
    if (insert(o)) return true;
    for (const std::uint32_t h : sides) {
      const std::uint32_t g = mesh_.twin(h);
      if (mesh_.may_collapse(h) && collapse(h, o)) return true;
      if (g != kNone && mesh_.may_collapse(g) && collapse(g, o)) return true;
    }
    for (const std::uint32_t h : sides) {
      if (!mesh_.fixed(mesh_.start(h)) && move(mesh_.start(h), o)) return true;
    }
    return false;
  }

  /// Smaller triangles in the same place, or on the input, so that more can be done next time.
  bool halve(const std::array<std::uint32_t, 3>& sides, const Offence& o) {
    std::uint32_t longest = kNone;
    for (const std::uint32_t h : sides) {
      if (may_split(h) && (longest == kNone || mesh_.length(h) > mesh_.length(longest)))
        longest = h;
    }
    if (longest == kNone || mesh_.length(longest) <= limits_.guard.spacing_m) return false;
    Vec3f at = (mesh_.position(mesh_.start(longest)) + mesh_.position(mesh_.end(longest))) * 0.5f;
    std::uint32_t triangle = o.input_triangle;
    if (limits_.insists) {
      const NearestPoint below = input_.tree().nearest(at, {});
      at = input_.tree().point(below);
      triangle = below.triangle;
    }
    if (!patch_.may_cut_at(longest, at)) return false;
    begin(o);
    put_split(longest, at);
    if (!guard_.fits_anyway()) return false;
    commit(patch_.cut(longest, at, triangle));
    return true;
  }

  bool may_split(std::uint32_t h) const { return mesh_.twin(h) != kNone && !mesh_.frozen(h); }

  void begin(const Offence& o) {
    guard_.begin();
    fresh_.clear();
    facets_.clear();
    taken_.clear();
    place_ = o.place;
    on_result_ = !o.must_reach;
    if (o.must_reach) guard_.reach(o.through);
  }
  void take(std::uint32_t t) {
    guard_.take(t);
    taken_.push_back(t);
  }
  void put(Vec3f a, Vec3f b, Vec3f c) {
    guard_.put(a, b, c);
    facets_.push_back({a, b, c});
  }
  /// Whether the change keeps the bound and folds nothing.
  bool fits(std::uint32_t from) {
    if (least_sine_ > 0.0f && !is_round()) return false;
    for (const auto& [a, b, c] : facets_) {
      // A side that stays is as far as it was.
      const float near_sq = 1e-6f * dot(c - b, c - b);
      if (on_result_ && nearest_on_triangle(place_, b, c, c).distance_sq < near_sq) return false;
      const Vec3f normal = normalized(cross(b - a, c - a));
      const NearestPoint near = input_.walk((a + b + c) * (1.0f / 3.0f), from, 0.0f);
      if (dot(normal, input_.tree().normal(near.triangle)) < limits_.least_facing) return false;
    }
    // What has been mended once stays so: or else one change undoes the other without end.
    for (const Vec3f p : places_) {
      if (is_near_taken(p)) guard_.reach(p);
    }
    return guard_.fits(from);
  }
  /// Whether the new triangles have no smaller angle than asked for, or than the old ones had.
  bool is_round() const {
    float before = least_sine_;
    for (const std::uint32_t t : taken_) {
      before = std::min(
          before, least_sine(mesh_.position(mesh_.start(3 * t)), mesh_.position(mesh_.end(3 * t)),
                             mesh_.position(mesh_.opposite(3 * t))));
    }
    return std::all_of(facets_.begin(), facets_.end(),
                       [&](const auto& f) { return least_sine(f[0], f[1], f[2]) >= before; });
  }
  bool is_near_taken(Vec3f p) const {
    const float bound_sq = kAbout * limits_.guard.error_m * limits_.guard.error_m;
    return std::any_of(taken_.begin(), taken_.end(), [&](std::uint32_t t) {
      return nearest_on_triangle(p, mesh_.position(mesh_.start(3 * t)),
                                 mesh_.position(mesh_.end(3 * t)),
                                 mesh_.position(mesh_.opposite(3 * t)))
                 .distance_sq <= bound_sq;
    });
  }
  void commit(const std::vector<std::uint32_t>& fresh) {
    guard_.commit(fresh);
    changed_.resize(mesh_.triangle_count(), 1);
    for (const std::uint32_t t : fresh) changed_[t] = 1;
  }

  /// The new triangles in the order of PatchMesh::split().
  void put_split(std::uint32_t h, Vec3f at) {
    const std::uint32_t g = mesh_.twin(h);
    const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
    const Vec3f c = mesh_.position(mesh_.opposite(h)), d = mesh_.position(mesh_.opposite(g));
    take(h / 3);
    take(g / 3);
    put(at, c, a);
    put(at, b, c);
    put(at, d, b);
    put(at, a, d);
  }
  bool split(std::uint32_t h, const Offence& o, Vec3f at, std::uint32_t triangle) {
    if (!patch_.may_cut_at(h, at)) return false;
    begin(o);
    put_split(h, at);
    if (!fits(triangle)) return false;
    commit(patch_.cut(h, at, triangle));
    return true;
  }

  bool flip(std::uint32_t h, const Offence& o) {
    const std::uint32_t g = mesh_.twin(h);
    const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
    const Vec3f c = mesh_.position(mesh_.opposite(h)), d = mesh_.position(mesh_.opposite(g));
    begin(o);
    take(h / 3);
    take(g / 3);
    put(c, a, d);
    put(c, d, b);
    if (!fits(patch_.hint[mesh_.opposite(h)])) return false;
    mesh_.flip(h);
    commit({h / 3, g / 3});
    return true;
  }

  bool insert(const Offence& o) {
    const std::uint32_t t = o.triangle;
    const std::uint32_t corners[3] = {mesh_.start(3 * t), mesh_.start(3 * t + 1),
                                      mesh_.start(3 * t + 2)};
    if (mesh_.frozen(3 * t) && mesh_.frozen(3 * t + 1) && mesh_.frozen(3 * t + 2)) return false;
    begin(o);
    take(t);
    float size = 0.0f;
    for (int k = 0; k < 3; ++k) {
      put(o.through, mesh_.position(corners[k]), mesh_.position(corners[(k + 1) % 3]));
      size += patch_.size[corners[k]] / 3.0f;
    }
    if (!fits(o.input_triangle)) return false;
    mesh_.insert(t, o.through);
    const auto t1 = static_cast<std::uint32_t>(mesh_.triangle_count()) - 2;
    commit({t, t1, t1 + 1});
    patch_.size.push_back(size);
    patch_.hint.push_back(o.input_triangle);
    return true;
  }

  bool collapse(std::uint32_t h, const Offence& o) {
    const std::uint32_t b = mesh_.end(h);
    begin(o);
    mesh_.each_out(mesh_.start(h), [&](std::uint32_t out) {
      take(out / 3);
      if (mesh_.end(out) == b || mesh_.opposite(out) == b) return true;
      put(mesh_.position(b), mesh_.position(mesh_.end(out)), mesh_.position(mesh_.opposite(out)));
      fresh_.push_back(out / 3);
      return true;
    });
    if (!fits(patch_.hint[b])) return false;
    mesh_.collapse(h);
    commit(fresh_);
    return true;
  }

  /// Onto that place, or onto the input below itself or the middle of its neighbours; or part of
  /// the way, where what hangs on its triangles is on
  /// the other side.
  bool move(std::uint32_t v, const Offence& o) {
    const Vec3f from = mesh_.position(v);
    const NearestPoint below = input_.tree().nearest(from, {});
    Vec3f sum{};
    float count = 0.0f;
    mesh_.each_neighbour(v, [&](std::uint32_t n) {
      sum += mesh_.position(n);
      count += 1.0f;
      return true;
    });
    const NearestPoint middle = input_.tree().nearest(sum / count, {});
    for (const float share : {1.0f, 0.5f, 0.25f}) {
      const auto towards = [&](Vec3f to, std::uint32_t triangle) {
        return move(v, o, share == 1.0f ? to : from + (to - from) * share, triangle);
      };
      if (towards(o.through, o.input_triangle) ||
          towards(input_.tree().point(below), below.triangle) ||
          towards(input_.tree().point(middle), middle.triangle)) {
        return true;
      }
    }
    return false;
  }
  bool move(std::uint32_t v, const Offence& o, Vec3f to, std::uint32_t triangle) {
    // Less than that mends nothing, and would keep better changes from being tried.
    if (norm(to - mesh_.position(v)) < kLeastMove * limits_.guard.error_m) return false;
    begin(o);
    mesh_.each_out(v, [&](std::uint32_t h) {
      take(h / 3);
      put(to, mesh_.position(mesh_.end(h)), mesh_.position(mesh_.opposite(h)));
      fresh_.push_back(h / 3);
      return true;
    });
    if (!fits(triangle)) return false;
    mesh_.move(v, to);
    commit(fresh_);
    patch_.hint[v] = triangle;
    return true;
  }

  RelaxPatch& patch_;
  PatchMesh& mesh_;
  Guard& guard_;
  const Reference& input_;
  const RelaxLimits& limits_;
  const std::vector<Vec3f>& places_;   ///< of the input, that were too far once
  std::vector<std::uint8_t> changed_;  ///< per triangle
  std::vector<std::uint32_t> fresh_;   ///< numbers of the triangles that a change makes
  std::vector<std::array<Vec3f, 3>> facets_;
  std::vector<std::uint32_t> taken_;  ///< triangles that it replaces
  float least_sine_ = 0.0f;           ///< of the smallest angles of new triangles; 0: any
  Vec3f place_{};                     ///< of the offence
  bool on_result_ = false;            ///< whether it is one of the result
};

}  // namespace

void mend(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Offence>& offences, const std::vector<Vec3f>& places) {
  Mending(patch, input, limits, places).run(offences);
}

}  // namespace cornice::remesh
