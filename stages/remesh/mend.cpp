// SPDX-License-Identifier: GPL-3.0-or-later
// Local repair: of the few changes that are possible at a triangle that leaves the bound, the first
// one that keeps it everywhere.
#include <algorithm>
#include <array>
#include <cmath>

#include "stages/remesh/change.h"

namespace cornice::remesh {
namespace {

using Kind = Change::Kind;

/// Of an offence's distance: what a change must reach that does not keep the bound.
constexpr float kNearer = 0.95f;
/// Of the bound: how far a vertex must move.
constexpr float kLeastMove = 0.1f;
/// Sine of the smallest angle to ask for: 22 degrees.
constexpr float kRoundSine = 0.37f;

class Mending {
 public:
  Mending(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Vec3f>& places)
      : patch_(patch),
        mesh_(patch.mesh),
        guard_(patch.guard),
        input_(input),
        limits_(limits),
        changer_(patch, input, limits, places) {}

  void run(const std::vector<Offence>& offences) {
    for (const Offence& o : offences) {
      // What a change nearby has made of it is told by the next measurement.
      if (mesh_.triangle_alive(o.triangle) && patch_.changed[o.triangle] == 0) mend(o);
    }
    for (const Offence& o : offences) patch_.changed[o.triangle] = 1;
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
      if (attempt({Kind::kSplit, h, o.through, o.input_triangle}, o)) return true;
    }
    for (const std::uint32_t h : sides) {
      if (attempt({Kind::kFlip, h}, o)) return true;
    }
    if (attempt({Kind::kInsert, o.triangle, o.through, o.input_triangle}, o)) return true;
    for (const std::uint32_t h : sides) {
      const std::uint32_t g = mesh_.twin(h);
      if (attempt({Kind::kCollapse, h}, o)) return true;
      if (g != kNone && attempt({Kind::kCollapse, g}, o)) return true;
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
      if (mesh_.twin(h) == kNone || mesh_.frozen(h)) continue;
      if (longest == kNone || mesh_.length(h) > mesh_.length(longest)) longest = h;
    }
    if (longest == kNone || mesh_.length(longest) <= limits_.guard.spacing_m) return false;
    const Vec3f middle =
        (mesh_.position(mesh_.start(longest)) + mesh_.position(mesh_.end(longest))) * 0.5f;
    Change cut{Kind::kSplit, longest, middle, o.input_triangle};
    if (limits_.insists) {
      const NearestPoint below = input_.tree().nearest(middle, {});
      cut.to = input_.tree().point(below);
      cut.input_triangle = below.triangle;
    }
    if (!changer_.may(cut)) return false;
    changer_.describe(cut);
    if (!changer_.fits_anyway()) return false;
    changer_.carry_out();
    return true;
  }

  /// Makes a change if it mends the offence, is round where that is asked for, and fits.
  bool attempt(const Change& change, const Offence& o) {
    if (!changer_.may(change)) return false;
    changer_.describe(change);
    if (least_sine_ > 0.0f && !is_round()) return false;
    if (!o.must_reach && keeps_side_at(o.place)) return false;
    if (!changer_.fits(o.must_reach ? &o.through : nullptr)) return false;
    changer_.carry_out();
    return true;
  }
  /// A side that stays is as far as it was.
  bool keeps_side_at(Vec3f place) const {
    return std::any_of(
        changer_.facets().begin(), changer_.facets().end(), [&](const Changer::Facet& f) {
          const Vec3f side = f[2] - f[1];
          return nearest_on_triangle(place, f[1], f[2], f[2]).distance_sq < 1e-6f * dot(side, side);
        });
  }
  /// Whether the new triangles have no smaller angle than asked for, or than the old ones had.
  bool is_round() const {
    float before = least_sine_;
    for (const std::uint32_t t : changer_.taken()) {
      before = std::min(
          before, least_sine(mesh_.position(mesh_.start(3 * t)), mesh_.position(mesh_.end(3 * t)),
                             mesh_.position(mesh_.opposite(3 * t))));
    }
    return std::all_of(changer_.facets().begin(), changer_.facets().end(),
                       [&](const auto& f) { return least_sine(f[0], f[1], f[2]) >= before; });
  }

  /// Onto that place, or onto the input below itself or the middle of its neighbours; or part of
  /// the way, where what hangs on its triangles is on
  /// the other side.
  bool move(std::uint32_t v, const Offence& o) {
    const Vec3f from = mesh_.position(v);
    const NearestPoint below = input_.tree().nearest(from, {});
    const NearestPoint middle = input_.tree().nearest(mesh_.middle_of_neighbours(v), {});
    for (const float share : {1.0f, 0.5f, 0.25f}) {
      const auto towards = [&](Vec3f to, std::uint32_t triangle) {
        const Vec3f at = share == 1.0f ? to : from + (to - from) * share;
        // Less than that mends nothing, and would keep better changes from being tried.
        return norm(at - from) >= kLeastMove * limits_.guard.error_m &&
               attempt({Kind::kMove, v, at, triangle}, o);
      };
      if (towards(o.through, o.input_triangle) ||
          towards(input_.tree().point(below), below.triangle) ||
          towards(input_.tree().point(middle), middle.triangle)) {
        return true;
      }
    }
    return false;
  }

  RelaxPatch& patch_;
  PatchMesh& mesh_;
  Guard& guard_;
  const Reference& input_;
  const RelaxLimits& limits_;
  Changer changer_;
  float least_sine_ = 0.0f;  ///< of the smallest angles of new triangles; 0: any
};

}  // namespace

void mend(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Offence>& offences, const std::vector<Vec3f>& places) {
  Mending(patch, input, limits, places).run(offences);
}

}  // namespace cornice::remesh
