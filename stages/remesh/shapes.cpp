// SPDX-License-Identifier: GPL-3.0-or-later
// Local repair of shapes: at a thin triangle, of all changes that leave fewer or less thin
// triangles, the best one that keeps the bound.
#include <algorithm>
#include <array>
#include <cmath>

#include "stages/remesh/change.h"

namespace cornice::remesh {
namespace {

using Kind = Change::Kind;

/// How much of the penalty a change must take away at least.
constexpr float kLeastGain = 0.05f;
/// Of the candidates, best first, so many are asked for.
constexpr std::size_t kMostTries = 16;

class Shaping {
 public:
  Shaping(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Vec3f>& places)
      : mesh_(patch.mesh), input_(input), changer_(patch, input, limits, places) {}

  void run() {
    struct Thin {
      float sine;
      std::uint32_t triangle;
    };
    std::vector<Thin> thin;
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
      if (!mesh_.triangle_alive(t)) continue;
      const float sine = sine_of(t);
      if (sine < kThinSine) thin.push_back({sine, t});
    }
    std::sort(thin.begin(), thin.end(), [](const Thin& a, const Thin& b) {
      return a.sine != b.sine ? a.sine < b.sine : a.triangle < b.triangle;
    });
    for (const Thin& one : thin) {
      if (mesh_.triangle_alive(one.triangle) && sine_of(one.triangle) < kThinSine) {
        round_off(one.triangle);
      }
    }
  }

 private:
  struct Candidate {
    float gain;
    Change change;
  };

  float sine_of(std::uint32_t t) const {
    return least_sine(mesh_.position(mesh_.start(3 * t)), mesh_.position(mesh_.end(3 * t)),
                      mesh_.position(mesh_.opposite(3 * t)));
  }
  /// 0 for a round triangle, more than 1 for a thin one.
  static float penalty(float sine) {
    return sine >= kThinSine ? 0.0f : 1.0f + 2.0f * (kThinSine - sine) / kThinSine;
  }

  void round_off(std::uint32_t t) {
    candidates_.clear();
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      propose_at_edge(h);
      if (!mesh_.fixed(mesh_.start(h))) propose_moves(mesh_.start(h));
    }
    std::stable_sort(candidates_.begin(), candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
    const std::size_t tries = std::min(candidates_.size(), kMostTries);
    for (std::size_t i = 0; i < tries; ++i) {
      changer_.describe(candidates_[i].change);
      if (!changer_.fits()) continue;
      changer_.carry_out();
      return;
    }
  }

  void propose_at_edge(std::uint32_t h) {
    const std::uint32_t g = mesh_.twin(h);
    if (g == kNone) return;
    propose({Kind::kFlip, h});
    propose({Kind::kCollapse, h});
    propose({Kind::kCollapse, g});
    const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
    const Vec3f c = mesh_.position(mesh_.opposite(h)), d = mesh_.position(mesh_.opposite(g));
    const Vec3f ab = b - a;
    propose_onto({Kind::kMerge, h}, (a + b) * 0.5f);
    propose_onto({Kind::kSplit, h}, (a + b) * 0.5f);
    const float foot = dot(c - a, ab) / std::max(dot(ab, ab), 1e-12f);
    if (foot > 0.1f && foot < 0.9f) {
      propose_onto({Kind::kSwing, h}, a + ab * foot);
      propose_onto({Kind::kSplit, h}, a + ab * foot);
    }
    const float other = dot(d - a, ab) / std::max(dot(ab, ab), 1e-12f);
    if (other > 0.1f && other < 0.9f) propose_onto({Kind::kSplit, h}, a + ab * other);
    propose_onto({Kind::kSwing, h}, (a + b + c + d) * 0.25f);
    propose_onto({Kind::kSwing, h}, mesh_.middle_of_neighbours(mesh_.opposite(h)));
    // The corner across, which a turn may pull off a crest.
    propose_onto({Kind::kSwing, g}, mesh_.middle_of_neighbours(mesh_.opposite(g)));
  }

  void propose_moves(std::uint32_t v) {
    const Vec3f from = mesh_.position(v);
    const Vec3f way = mesh_.middle_of_neighbours(v) - from;
    for (const float share : {1.0f, 0.6f, 0.3f}) {
      propose_onto({Kind::kMove, v}, from + way * share);
    }
    mesh_.each_neighbour(v, [&](std::uint32_t n) {
      const Vec3f to = mesh_.position(n) - from;
      for (const float share : {0.4f, 0.2f, -0.2f}) ways_.push_back(from + to * share);
      return true;
    });
    for (const Vec3f to : ways_) propose_onto({Kind::kMove, v}, to);
    ways_.clear();
  }

  /// The place is put onto the input.
  void propose_onto(Change change, Vec3f place) {
    const NearestPoint on = input_.tree().nearest(place, {});
    change.to = input_.tree().point(on);
    change.input_triangle = on.triangle;
    propose(change);
  }

  void propose(const Change& change) {
    if (!changer_.may(change)) return;
    changer_.describe(change);
    float gain = 0.0f;
    for (const std::uint32_t t : changer_.taken()) gain += penalty(sine_of(t));
    for (const auto& [a, b, c] : changer_.facets()) gain -= penalty(least_sine(a, b, c));
    if (gain > kLeastGain) candidates_.push_back({gain, change});
  }

  PatchMesh& mesh_;
  const Reference& input_;
  Changer changer_;
  std::vector<Candidate> candidates_;
  std::vector<Vec3f> ways_;
};

}  // namespace

bool is_thin(Vec3f a, Vec3f b, Vec3f c) { return least_sine(a, b, c) < kThinSine; }

void mend_shapes(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
                 const std::vector<Vec3f>& places) {
  Shaping(patch, input, limits, places).run();
}

}  // namespace cornice::remesh
