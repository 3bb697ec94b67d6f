// SPDX-License-Identifier: GPL-3.0-or-later
// Single changes to a patch, described before they are carried out.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "stages/remesh/relax.h"

namespace cornice::remesh {

/// What may be done at one place.
struct Change {
  enum class Kind {
    kSplit,     ///< edge `at` is cut at `to`
    kInsert,    ///< triangle `at` gets a vertex at `to`
    kFlip,      ///< edge `at` is turned
    kSwing,     ///< edge `at` is turned, and the corner opposite of it moves to `to`
    kCollapse,  ///< the start of edge `at` goes onto its end
    kMerge,     ///< the ends of edge `at` become one at `to`
    kMove,      ///< vertex `at` moves to `to`
  };
  Kind kind;
  std::uint32_t at;
  Vec3f to{};
  std::uint32_t input_triangle = 0;  ///< near `to`
};

/// Describes changes to a patch and carries them out.
class Changer {
 public:
  Changer(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Vec3f>& places)
      : patch_(patch), mesh_(patch.mesh), input_(input), limits_(limits), places_(places) {
    patch.changed.assign(mesh_.triangle_count(), 0);
  }

  /// Whether the mesh stays a manifold and what is fixed stays.
  bool may(const Change& change) const;
  /// What the change makes of the triangles; for one that may be done.
  void describe(const Change& change);
  const std::vector<std::uint32_t>& taken() const { return taken_; }
  using Facet = std::array<Vec3f, 3>;  ///< all of one change from the same vertex on
  const std::vector<Facet>& facets() const { return facets_; }

  /// Whether what has been described folds nothing and keeps the bound everywhere, at the places
  /// that have been mended before as well, and at `reach` if that is given.
  bool fits(const Vec3f* reach = nullptr);
  /// As if it did, where the surface stays; false where a triangle would have no area.
  bool fits_anyway();
  /// What has been described and fits. The new triangles are marked in `patch.changed`.
  void carry_out();

 private:
  void describe_ring(std::uint32_t v, std::uint32_t without, Vec3f to);
  void describe_insertion(std::uint32_t t, Vec3f to);
  void describe_split(std::uint32_t h, Vec3f to);
  void describe_turn(std::uint32_t h);
  void describe_collapse(std::uint32_t h);
  void put(Vec3f a, Vec3f b, Vec3f c, std::uint32_t number);
  void tell_guard();
  bool is_near_taken(Vec3f p) const;

  RelaxPatch& patch_;
  PatchMesh& mesh_;
  const Reference& input_;
  const RelaxLimits& limits_;
  const std::vector<Vec3f>& places_;  ///< of the input, that were too far once
  Change change_{};
  std::vector<std::uint32_t> taken_;  ///< triangles that go
  std::vector<Facet> facets_;
  std::vector<std::uint32_t> fresh_;  ///< the numbers that these get
};

/// Of the smallest angle of a triangle that counts as thin: 21 degrees, one more than is wanted.
inline constexpr float kThinSine = 0.358f;
/// Sine of a triangle's smallest angle.
float least_sine(Vec3f a, Vec3f b, Vec3f c);

}  // namespace cornice::remesh
