// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/refine.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace cornice::compare {
namespace {

constexpr std::uint32_t kWhole = 0xffffffffu;
/// Rounds: edges of 100 km would be cut to 2 m.
constexpr int kMostRounds = 16;

class Refiner {
 public:
  Refiner(Surface& surface, std::vector<std::uint8_t>& marks, float longest_m)
      : surface_(surface), marks_(marks), longest_sq_(longest_m * longest_m) {}

  /// One halving of all long edges; false where there was none.
  bool round() {
    middles_.clear();
    triangles_.clear();
    new_marks_.clear();
    for (std::size_t t = 0; t < surface_.triangles.size(); ++t) cut(t);
    if (middles_.empty()) return false;
    surface_.triangles.swap(triangles_);
    marks_.swap(new_marks_);
    return true;
  }

 private:
  std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
    const Vec3f pa = surface_.positions[a], pb = surface_.positions[b];
    const Vec3f edge = pb - pa;
    if (!(dot(edge, edge) > longest_sq_)) return kWhole;
    const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    const auto [at, fresh] =
        middles_.try_emplace(key, static_cast<std::uint32_t>(surface_.positions.size()));
    if (fresh) {
      surface_.positions.push_back((pa + pb) * 0.5f);
      if (!surface_.normals.empty()) {
        surface_.normals.push_back(normalized(surface_.normals[a] + surface_.normals[b]));
      }
      if (!surface_.curvature.empty()) {
        surface_.curvature.push_back(0.5f * (surface_.curvature[a] + surface_.curvature[b]));
      }
    }
    return at->second;
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::size_t from) {
    triangles_.push_back({a, b, c});
    if (!marks_.empty()) new_marks_.push_back(marks_[from]);
  }

  /// Into two, three or four, as many as edges are long.
  void cut(std::size_t t) {
    Triangle c = surface_.triangles[t];
    std::array<std::uint32_t, 3> m{middle(c[0], c[1]), middle(c[1], c[2]), middle(c[2], c[0])};
    const auto whole = std::count(m.begin(), m.end(), kWhole);
    if (whole == 3) return add(c[0], c[1], c[2], t);
    if (whole == 0) {
      add(c[0], m[0], m[2], t);
      add(m[0], c[1], m[1], t);
      add(m[2], m[1], c[2], t);
      return add(m[0], m[1], m[2], t);
    }
    // Turned so that the edge that differs from the other two comes first.
    while ((m[0] == kWhole) != (whole == 1) || (m[1] == kWhole) == (whole == 1)) {
      std::rotate(c.begin(), c.begin() + 1, c.end());
      std::rotate(m.begin(), m.begin() + 1, m.end());
    }
    if (whole == 2) {
      add(c[0], m[0], c[2], t);
      return add(m[0], c[1], c[2], t);
    }
    add(m[1], c[2], m[2], t);
    add(c[0], c[1], m[1], t);
    add(c[0], m[1], m[2], t);
  }

  Surface& surface_;
  std::vector<std::uint8_t>& marks_;
  float longest_sq_;
  std::unordered_map<std::uint64_t, std::uint32_t> middles_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint8_t> new_marks_;
};

}  // namespace

void refine_long_edges(Surface& surface, std::vector<std::uint8_t>& marks, float longest_m) {
  Refiner refiner(surface, marks, longest_m);
  for (int round = 0; round < kMostRounds && refiner.round(); ++round) {
  }
}

}  // namespace cornice::compare
