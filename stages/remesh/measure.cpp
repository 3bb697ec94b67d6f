// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/measure.h"

#include <array>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"

namespace cornice::remesh {
namespace {

constexpr std::size_t kGrain = 8192;
/// Places inside a triangle lie so many times as far apart as those on its sides.
constexpr float kInnerSpacings = 2.0f;
/// Side of the columns by which triangles near places are found.
constexpr float kColumnSpacings = 8.0f;

/// A place of the input that is farther than the bound from what its corners hang on.
struct FarPlace {
  Vec3f at;
  std::uint32_t input_triangle;
  std::uint32_t carrier;
  float distance_sq;  ///< of the carrier
};

struct Found {
  float largest_sq = 0.0f;
  float kept_sq = 0.0f;
  std::vector<std::pair<float, Offence>> offences;
  std::vector<FarPlace> far;
  std::vector<Borrowing> borrowings;

  /// Whether that is too far.
  bool add(float distance_sq, float bound_m) {
    largest_sq = std::max(largest_sq, distance_sq);
    if (distance_sq > bound_m * bound_m) return true;
    kept_sq = std::max(kept_sq, distance_sq);
    return false;
  }
  void add(Found& other) {
    largest_sq = std::max(largest_sq, other.largest_sq);
    kept_sq = std::max(kept_sq, other.kept_sq);
    offences.insert(offences.end(), other.offences.begin(), other.offences.end());
    far.insert(far.end(), other.far.begin(), other.far.end());
  }
};

struct Box {
  Vec3f low, high;

  static Box of(Vec3f p, Vec3f q, Vec3f r, float reach) {
    return {{std::min({p.x, q.x, r.x}) - reach, std::min({p.y, q.y, r.y}) - reach, 0.0f},
            {std::max({p.x, q.x, r.x}) + reach, std::max({p.y, q.y, r.y}) + reach, 0.0f}};
  }
};

/// A set of square columns.
class Columns {
 public:
  explicit Columns(float side) : side_(side) {}

  void add(const Box& box) {
    each(box, [&](std::uint64_t key) {
      keys_.push_back(key);
      return true;
    });
  }
  /// After the last add().
  void sort() {
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  }
  bool meet(const Box& box) const {
    return !each(box, [&](std::uint64_t key) {
      return !std::binary_search(keys_.begin(), keys_.end(), key);
    });
  }

 private:
  /// Stops where visit returns false and returns false then.
  template <class Visit>
  bool each(const Box& box, Visit&& visit) const {
    for (std::int32_t x = column(box.low.x); x <= column(box.high.x); ++x) {
      for (std::int32_t y = column(box.low.y); y <= column(box.high.y); ++y) {
        if (!visit(static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32 |
                   static_cast<std::uint32_t>(y))) {
          return false;
        }
      }
    }
    return true;
  }
  std::int32_t column(float value) const {
    return static_cast<std::int32_t>(std::floor(value / side_));
  }

  float side_;
  std::vector<std::uint64_t> keys_;
};

Box box_of(const WorkMesh& mesh, std::uint32_t t, float reach) {
  const Triangle& c = mesh.triangles[t];
  return Box::of(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]], reach);
}

/// The triangles of the result that come within `reach` of the columns in which the places lie.
std::vector<std::uint32_t> triangles_near(const WorkMesh& mesh, const std::vector<FarPlace>& places,
                                          float side, float reach) {
  Columns wanted(side);
  for (const FarPlace& far : places) wanted.add(Box::of(far.at, far.at, far.at, 0.0f));
  wanted.sort();
  std::vector<std::uint32_t> found;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (wanted.meet(box_of(mesh, t, reach))) found.push_back(t);
  }
  return found;
}

/// From places of the input to the result.
class Forth {
 public:
  Forth(const WorkMesh& mesh, const Reference& input, const MeasureLimits& limits, int threads)
      : mesh_(mesh),
        input_(input),
        limits_(limits),
        carrier_(input.positions().size(), Reference::kNoTriangle) {
    parallel_for(mesh.triangles.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        for (std::uint32_t s = mesh.sample_first[t]; s < mesh.sample_first[t + 1]; ++s) {
          carrier_[mesh.samples[s]] = static_cast<std::uint32_t>(t);
        }
      }
    });
  }

  Found run(const std::vector<Borrowing>& borrowings, int threads) const {
    Found found = run_on_triangles(threads);
    look_again(borrowings, found);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (mesh_.error[t] <= limits_.bound_m) {
        found.add(mesh_.error[t] * mesh_.error[t], limits_.bound_m);
        continue;
      }
      // What has been mended may lie nearer to another triangle than to the one it hangs on.
      for (std::uint32_t s = mesh_.sample_first[t]; s < mesh_.sample_first[t + 1]; ++s) {
        const std::uint32_t id = mesh_.samples[s];
        look(input_.positions()[id], input_.triangle_at(id), {t, t, t}, found);
      }
    }
    search_far(found, threads);
    return found;
  }

 private:
  using Three = std::array<std::uint32_t, 3>;

  Found run_on_triangles(int threads) const {
    return parallel_reduce(
        input_.triangles().size(), kGrain, threads, Found{},
        [&](std::size_t begin, std::size_t end) {
          Found found;
          for (std::size_t t = begin; t < end; ++t) look(static_cast<std::uint32_t>(t), found);
          return found;
        },
        [](Found& all, Found& part) { all.add(part); });
  }

  /// What is near a triangle that has not changed still is.
  void look_again(const std::vector<Borrowing>& borrowings, Found& found) const {
    if (borrowings.empty()) return;
    const float side = kColumnSpacings * limits_.spacing_m;
    Columns changed(side);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (mesh_.changed[t] != 0) changed.add(box_of(mesh_, t, side));
    }
    changed.sort();
    for (const Borrowing& one : borrowings) {
      const Triangle& c = input_.triangles()[one.input_triangle];
      const auto& p = input_.positions();
      if (changed.meet(Box::of(p[c[0]], p[c[1]], p[c[2]], one.distance_m))) {
        look_over(one.input_triangle, found);
      } else {
        found.borrowings.push_back(one);
      }
    }
  }

  void look(std::uint32_t t, Found& found) const {
    const Three at = carriers(t);
    if (at[0] == at[1] && at[1] == at[2]) return;
    const bool changed = std::any_of(std::begin(at), std::end(at), [&](std::uint32_t carrier) {
      return carrier != Reference::kNoTriangle && mesh_.changed[carrier] != 0;
    });
    if (changed) look_over(t, found);
  }
  Three carriers(std::uint32_t t) const {
    const Triangle& c = input_.triangles()[t];
    return {carrier_[c[0]], carrier_[c[1]], carrier_[c[2]]};
  }

  void look_over(std::uint32_t t, Found& found) const {
    const Triangle& c = input_.triangles()[t];
    const Three at = carriers(t);
    const Vec3f p[3] = {input_.positions()[c[0]], input_.positions()[c[1]],
                        input_.positions()[c[2]]};
    for (int k = 0; k < 3; ++k) {
      // Each side by one of its triangles.
      const std::uint32_t twin = input_.twins()[3 * t + static_cast<std::uint32_t>(k)];
      if (twin < kNoTwin && twin < 3 * t) continue;
      const Vec3f middle = (p[k] + p[(k + 1) % 3]) * 0.5f;
      if (at[k] == at[(k + 1) % 3] || !look(middle, t, at, found)) continue;
      look((p[k] + middle) * 0.5f, t, at, found);
      look((p[(k + 1) % 3] + middle) * 0.5f, t, at, found);
    }
    const Vec3f centre = (p[0] + p[1] + p[2]) / 3.0f;
    if (!look(centre, t, at, found)) return;
    for (const Vec3f corner : p) look((corner + centre) * 0.5f, t, at, found);
  }

  /// Returns whether that is so far that more places round it are worth a look.
  bool look(Vec3f p, std::uint32_t t, const Three& at, Found& found) const {
    NearestPoint best;
    for (const std::uint32_t carrier : at) {
      if (carrier == Reference::kNoTriangle) continue;
      const Triangle& c = mesh_.triangles[carrier];
      NearestPoint near = nearest_on_triangle(p, mesh_.positions[c[0]], mesh_.positions[c[1]],
                                              mesh_.positions[c[2]]);
      near.triangle = carrier;
      if (near.distance_sq < best.distance_sq) best = near;
      if (best.distance_sq <= limits_.enough_m * limits_.enough_m) break;
    }
    if (best.distance_sq > limits_.bound_m * limits_.bound_m) {
      found.far.push_back({p, t, best.triangle, best.distance_sq});
    } else {
      found.add(best.distance_sq, limits_.bound_m);
    }
    return best.distance_sq > limits_.enough_m * limits_.enough_m;
  }

  /// Where what a place hangs on is too far, another triangle may be near.
  void search_far(Found& found, int threads) const {
    if (found.far.empty()) return;
    const std::vector<std::uint32_t> numbers =
        triangles_near(mesh_, found.far, kColumnSpacings * limits_.spacing_m, limits_.bound_m);
    std::vector<Triangle> triangles;
    for (const std::uint32_t t : numbers) triangles.push_back(mesh_.triangles[t]);
    const TriangleTree tree(mesh_.positions, triangles, threads);
    for (const FarPlace& far : found.far) {
      NearestQuery query;
      query.max_distance_sq = far.distance_sq;
      NearestPoint near = tree.nearest(far.at, query);
      std::uint32_t triangle = far.carrier;
      if (near.found()) {
        triangle = numbers[near.triangle];
      } else {
        near.distance_sq = far.distance_sq;
      }
      found.borrowings.push_back({far.input_triangle, std::sqrt(near.distance_sq)});
      if (found.add(near.distance_sq, limits_.bound_m)) {
        found.offences.push_back(
            {near.distance_sq, {triangle, far.at, far.input_triangle, true, {}, 0.0f}});
      }
    }
  }

  const WorkMesh& mesh_;
  const Reference& input_;
  const MeasureLimits limits_;
  std::vector<std::uint32_t> carrier_;
};

/// From places of a triangle of the result to the input.
class Back {
 public:
  Back(const WorkMesh& mesh, const Reference& input, const MeasureLimits& limits, Found& found)
      : mesh_(mesh), input_(input), limits_(limits), found_(found) {}

  void look(std::uint32_t t) {
    const Triangle& c = mesh_.triangles[t];
    offence_ = {t, {}, 0};
    worst_sq_ = limits_.bound_m * limits_.bound_m;
    from_ = mesh_.hint[c[0]];
    const Vec3f p[3] = {mesh_.positions[c[0]], mesh_.positions[c[1]], mesh_.positions[c[2]]};
    const std::uint32_t first = from_;
    for (int k = 0; k < 3; ++k) {
      // Each side by one of its triangles; one with fixed ends may be an open one.
      const std::uint32_t v = c[k], w = c[(k + 1) % 3];
      if (v < w || (mesh_.fixed[v] != 0 && mesh_.fixed[w] != 0)) {
        look_along(p[k], p[(k + 1) % 3] - p[k]);
      }
    }
    from_ = first;
    look_inside(p[0], p[1] - p[0], p[2] - p[0]);
    if (worst_sq_ > limits_.bound_m * limits_.bound_m) {
      found_.offences.push_back({worst_sq_, offence_});
    }
  }

 private:
  void look_along(Vec3f a, Vec3f ab) {
    const int n = std::max(2, static_cast<int>(std::ceil(norm(ab) / limits_.spacing_m)));
    const float step = 1.0f / static_cast<float>(n);
    bool was_far = false;
    for (int i = 0; i < n; ++i) {
      const float u = static_cast<float>(i) * step;
      const bool is_far = look(a + ab * u);
      if (is_far && !was_far && i > 0) look(a + ab * (u - 0.5f * step));
      if (is_far) look(a + ab * (u + 0.5f * step));
      was_far = is_far;
    }
  }

  /// Distances are largest where a side crosses one of the input's or below a vertex of the input,
  /// which is looked at the other way: unless the input is folded there.
  void look_inside(Vec3f a, Vec3f ab, Vec3f ac) {
    const float longest = std::sqrt(std::max({dot(ab, ab), dot(ac, ac), dot(ac - ab, ac - ab)}));
    const int n =
        std::max(3, static_cast<int>(std::ceil(longest / (kInnerSpacings * limits_.spacing_m))));
    const float step = 1.0f / static_cast<float>(n);
    for (int i = 1; i < n; ++i) {
      for (int j = 1; i + j < n; ++j) {
        const Vec3f p =
            a + ab * (static_cast<float>(i) * step) + ac * (static_cast<float>(j) * step);
        if (!look(p)) continue;
        for (const Vec3f aside : {ab, ac, ac - ab}) {
          look(p + aside * (0.5f * step));
          look(p - aside * (0.5f * step));
        }
      }
    }
  }

  /// Returns whether that is so far that more places round it are worth a look.
  bool look(Vec3f p) {
    const NearestPoint near = input_.near(p, from_, limits_.enough_m * limits_.enough_m,
                                          limits_.search_m * limits_.search_m);
    from_ = near.triangle;
    const bool is_far = near.distance_sq > limits_.enough_m * limits_.enough_m;
    if (!found_.add(near.distance_sq, limits_.bound_m) || near.distance_sq <= worst_sq_) {
      return is_far;
    }
    worst_sq_ = near.distance_sq;
    offence_.place = p;
    offence_.through = input_.tree().point(near);
    offence_.input_triangle = near.triangle;
    return is_far;
  }

  const WorkMesh& mesh_;
  const Reference& input_;
  const MeasureLimits& limits_;
  Found& found_;
  Offence offence_{};
  float worst_sq_ = 0.0f;
  std::uint32_t from_ = 0;
};

/// Each triangle once, with its largest distance.
std::vector<Borrowing> sorted(std::vector<Borrowing> all) {
  std::sort(all.begin(), all.end(), [](const Borrowing& a, const Borrowing& b) {
    return a.input_triangle != b.input_triangle ? a.input_triangle < b.input_triangle
                                                : a.distance_m > b.distance_m;
  });
  all.erase(std::unique(all.begin(), all.end(),
                        [](const Borrowing& a, const Borrowing& b) {
                          return a.input_triangle == b.input_triangle;
                        }),
            all.end());
  return all;
}

}  // namespace

Distances measure_distances(const WorkMesh& mesh, const Reference& input,
                            const MeasureLimits& limits, const std::vector<Borrowing>& borrowings,
                            int threads) {
  Distances distances;
  Found forth = Forth(mesh, input, limits, threads).run(borrowings, threads);
  Found back = parallel_reduce(
      mesh.triangles.size(), 1024, threads, Found{},
      [&](std::size_t begin, std::size_t end) {
        Found found;
        Back of_triangle(mesh, input, limits, found);
        for (std::size_t t = begin; t < end; ++t) {
          if (mesh.changed[t] != 0) of_triangle.look(static_cast<std::uint32_t>(t));
        }
        return found;
      },
      [](Found& all, Found& part) { all.add(part); });
  distances.borrowings = sorted(std::move(forth.borrowings));
  distances.input_to_result_m = std::sqrt(forth.largest_sq);
  distances.result_to_input_m = std::sqrt(back.largest_sq);
  distances.kept_m = std::sqrt(std::max(forth.kept_sq, back.kept_sq));
  forth.offences.insert(forth.offences.end(), back.offences.begin(), back.offences.end());
  std::stable_sort(forth.offences.begin(), forth.offences.end(), [](const auto& a, const auto& b) {
    return a.second.triangle != b.second.triangle ? a.second.triangle < b.second.triangle
                                                  : a.first > b.first;
  });
  for (const auto& [distance_sq, offence] : forth.offences) {
    if (!distances.offences.empty() && distances.offences.back().triangle == offence.triangle) {
      continue;
    }
    distances.offences.push_back(offence);
    distances.offences.back().distance_m = std::sqrt(distance_sq);
  }
  return distances;
}

}  // namespace cornice::remesh
