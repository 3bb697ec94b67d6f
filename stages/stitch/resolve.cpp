// SPDX-License-Identifier: GPL-3.0-or-later
// Nearest-vertex projection of borders and collapse of what lies between, extended by insertion
// where collapsing would move the border far, and by corners.
#include "stages/stitch/resolve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <flann/flann.hpp>
#include <limits>
#include <memory>
#include <set>

namespace cornice::stitch {
namespace {

constexpr double kUnits = 1024.0;  // a metre
constexpr std::uint32_t kNobody = 0xffffffffu;

Vec3d on_lattice(Vec3d p) {
  return {std::round(p.x * kUnits) / kUnits, std::round(p.y * kUnits) / kUnits,
          std::round(p.z * kUnits) / kUnits};
}

/// FLANN's tree over the border vertices of one tile, relative to `origin`.
class BorderTree {
 public:
  BorderTree(const TileBorder& border, Vec3d origin) : origin_(origin) {
    for (const BorderVertex& v : border.vertices) {
      local_.push_back((v.position - origin).template cast<float>());
    }
    index_ = std::make_unique<flann::Index<flann::L2_Simple<float>>>(
        flann::Matrix<float>(&local_[0].x, local_.size(), 3), flann::KDTreeSingleIndexParams(10));
    index_->buildIndex();
  }
  std::uint32_t nearest(Vec3d p, double& distance) const {
    Vec3f q = (p - origin_).cast<float>();
    std::size_t id = 0;
    float distance_sq = 0.0f;
    flann::Matrix<std::size_t> ids(&id, 1, 1);
    flann::Matrix<float> distances(&distance_sq, 1, 1);
    index_->knnSearch(flann::Matrix<float>(&q.x, 1, 3), ids, distances, 1,
                      flann::SearchParams(-1, 0.0f));
    distance = std::sqrt(static_cast<double>(distance_sq));
    return static_cast<std::uint32_t>(id);
  }

 private:
  Vec3d origin_;
  std::vector<Vec3f> local_;
  std::unique_ptr<flann::Index<flann::L2_Simple<float>>> index_;
};

class Resolution {
 public:
  Resolution(const std::vector<TileBorder>& tiles, const Options& options)
      : tiles_(tiles), options_(options) {
    plan_.tiles.resize(tiles.size());
    settled_.resize(tiles.size());
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      settled_[t].assign(tiles[t].vertices.size(), false);
      place_.emplace_back();
      for (const BorderVertex& v : tiles[t].vertices) place_[t].push_back(v.position);
      boxes_.emplace_back();
      for (const BorderVertex& v : tiles[t].vertices) boxes_[t].add(v.position.x, v.position.y);
      trees_.push_back(tiles[t].vertices.empty()
                           ? nullptr
                           : std::make_unique<BorderTree>(tiles[t], tiles[t].origin));
    }
  }

  Plan run() {
    find_pairs();
    settle_corners();
    for (const auto& [a, b] : loose_pairs_) settle_pair(a, b);
    for (const auto& [a, b] : loose_pairs_) fill_gaps(a, b);
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
      for (std::size_t i = 0; i < place_[t].size(); ++i) {
        if (place_[t][i] != tiles_[t].vertices[i].position) {
          plan_.tiles[t].move[tiles_[t].vertices[i].vertex] = place_[t][i];
        }
      }
    }
    return std::move(plan_);
  }

 private:
  /// Pairs of tiles whose borders come near each other; those that match already are left alone.
  void find_pairs() {
    using Place = std::array<double, 3>;
    std::map<Place, std::vector<std::pair<std::uint32_t, std::uint32_t>>> places;
    for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
      for (std::uint32_t i = 0; i < place_[t].size(); ++i) {
        const Vec3d p = place_[t][i];
        places[{p.x, p.y, p.z}].push_back({t, i});
      }
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint64_t> exact;
    for (const auto& [p, owners] : places) {
      std::set<std::uint32_t> who;
      for (const auto& [t, i] : owners) who.insert(t);
      if (who.size() < 2) continue;
      plan_.exact_vertices += owners.size();
      for (const auto& [t, i] : owners) settled_[t][i] = true;
      for (auto a = who.begin(); a != who.end(); ++a) {
        for (auto b = std::next(a); b != who.end(); ++b) ++exact[{*a, *b}];
      }
    }
    for (std::uint32_t a = 0; a < tiles_.size(); ++a) {
      for (std::uint32_t b = a + 1; b < tiles_.size(); ++b) {
        if (!trees_[a] || !trees_[b]) continue;
        if (!boxes_[a].grown(options_.reach_m).intersects(boxes_[b])) continue;
        std::uint64_t near = 0;
        for (const Vec3d p : place_[b]) {
          double distance = 0.0;
          trees_[a]->nearest(p, distance);
          near += distance <= options_.reach_m;
        }
        const auto found = exact.find({a, b});
        const std::uint64_t same = found == exact.end() ? 0 : found->second;
        // Vertices near a seam that matches are rims of holes beside it.
        if (near > 0 && 2 * same < near) loose_pairs_.push_back({a, b});
      }
    }
  }

  /// Settles the best meeting place of three or more tiles within reach, before their edges.
  void settle_corners() {
    struct Corner {
      double spread;
      std::vector<std::pair<std::uint32_t, std::uint32_t>> members;
    };
    std::vector<Corner> corners;
    for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
      for (std::uint32_t i = 0; i < place_[t].size(); ++i) {
        if (settled_[t][i]) continue;
        Corner corner{0.0, {{t, i}}};
        for (std::uint32_t o = t + 1; o < tiles_.size(); ++o) {
          if (!trees_[o]) continue;
          const Vec3d p = place_[t][i];
          if (!boxes_[o].grown(options_.reach_m).contains(p.x, p.y)) continue;
          double distance = 0.0;
          const std::uint32_t j = trees_[o]->nearest(p, distance);
          if (distance > options_.reach_m || settled_[o][j]) continue;
          corner.members.push_back({o, j});
          corner.spread = std::max(corner.spread, distance);
        }
        if (corner.members.size() > 2) corners.push_back(std::move(corner));
      }
    }
    std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
      if (a.members.size() != b.members.size()) return a.members.size() > b.members.size();
      return a.spread != b.spread ? a.spread < b.spread : a.members < b.members;
    });
    std::vector<Vec3d> done;
    for (const Corner& corner : corners) {
      const auto [t, i] = corner.members[0];
      const Vec3d at = on_lattice(place_[t][i]);
      const bool taken = std::any_of(done.begin(), done.end(), [&](Vec3d d) {
        return norm(d - at) <= 4.0 * options_.reach_m;
      });
      if (taken) continue;
      done.push_back(at);
      ++plan_.corners;
      for (const auto& [o, j] : corner.members) settle(o, j, at);
    }
  }

  void settle(std::uint32_t t, std::uint32_t i, Vec3d at) {
    plan_.projected += place_[t][i] != at;
    place_[t][i] = at;
    settled_[t][i] = true;
  }

  /// First pass of the reference: mutual nearest vertices become one, at the first tile's place.
  void settle_pair(std::uint32_t a, std::uint32_t b) {
    for (std::uint32_t j = 0; j < place_[b].size(); ++j) {
      if (settled_[b][j]) continue;
      double distance = 0.0, back = 0.0;
      const std::uint32_t i = trees_[a]->nearest(tiles_[b].vertices[j].position, distance);
      if (distance > options_.reach_m) continue;
      const std::uint32_t again = trees_[b]->nearest(tiles_[a].vertices[i].position, back);
      if (again != j) continue;
      const Vec3d at = settled_[a][i] ? place_[a][i] : on_lattice(place_[a][i]);
      settle(a, i, at);
      settle(b, j, at);
    }
  }

  /// Second pass: what lies between two neighbouring matches on either side.
  void fill_gaps(std::uint32_t a, std::uint32_t b) {
    using Place = std::array<double, 3>;
    std::map<Place, std::uint32_t> of_b;
    for (std::uint32_t j = 0; j < place_[b].size(); ++j) {
      const Vec3d p = place_[b][j];
      if (settled_[b][j]) of_b[{p.x, p.y, p.z}] = j;
    }
    const auto partner = [&](std::uint32_t i) {
      const Vec3d p = place_[a][i];
      const auto found = settled_[a][i] ? of_b.find({p.x, p.y, p.z}) : of_b.end();
      return found == of_b.end() ? kNobody : found->second;
    };
    for (std::uint32_t i = 0; i < place_[a].size(); ++i) {
      const std::uint32_t from = partner(i);
      if (from == kNobody) continue;
      std::vector<std::uint32_t> mine, theirs;
      const std::uint32_t end = walk(a, i, mine);
      if (end == kNobody) continue;
      const std::uint32_t to = partner(end);
      // The other tile goes along the seam the other way round.
      if (to == kNobody || walk(b, to, theirs) != from) continue;
      std::reverse(theirs.begin(), theirs.end());
      if (mine.empty() && theirs.empty()) continue;
      const double here = way_length(a, i, end, mine), there = way_length(b, from, to, theirs);
      // Round a hole the ways differ; along a seam they do not.
      if (std::abs(here - there) > 2.0 * options_.reach_m + 0.25 * std::max(here, there)) continue;
      fill_gap(a, i, end, mine, b, from, to, theirs);
    }
  }

  double way_length(std::uint32_t t, std::uint32_t from, std::uint32_t to,
                    const std::vector<std::uint32_t>& between) const {
    double sum = 0.0;
    Vec3d last = place_[t][from];
    for (const std::uint32_t v : between) {
      sum += norm(place_[t][v] - last);
      last = place_[t][v];
    }
    return sum + norm(place_[t][to] - last);
  }

  /// Border vertices of tile t after i that are not settled, into `between`; returns the settled
  /// one that ends them, kNobody where there is none.
  std::uint32_t walk(std::uint32_t t, std::uint32_t i, std::vector<std::uint32_t>& between) const {
    std::uint32_t at = tiles_[t].vertices[i].next;
    while (at != i && !settled_[t][at]) {
      between.push_back(at);
      at = tiles_[t].vertices[at].next;
    }
    return at == i ? kNobody : at;
  }

  /// Shares of the way from `from` to `to` at the vertices between them.
  std::vector<double> shares(std::uint32_t t, std::uint32_t from, std::uint32_t to,
                             const std::vector<std::uint32_t>& between) const {
    std::vector<double> way;
    double sum = 0.0;
    Vec3d last = place_[t][from];
    for (const std::uint32_t v : between) {
      sum += norm(place_[t][v] - last);
      way.push_back(sum);
      last = place_[t][v];
    }
    sum += norm(place_[t][to] - last);
    for (double& w : way) w /= std::max(sum, 1e-12);
    return way;
  }

  void fill_gap(std::uint32_t a, std::uint32_t a_from, std::uint32_t a_to,
                const std::vector<std::uint32_t>& mine, std::uint32_t b, std::uint32_t b_from,
                std::uint32_t b_to, const std::vector<std::uint32_t>& theirs) {
    struct Stop {
      double share;
      bool of_a;
      std::uint32_t index;
    };
    std::vector<Stop> stops;
    const std::vector<double> ways_a = shares(a, a_from, a_to, mine);
    const std::vector<double> ways_b = shares(b, b_from, b_to, theirs);
    for (std::size_t k = 0; k < mine.size(); ++k) stops.push_back({ways_a[k], true, mine[k]});
    for (std::size_t k = 0; k < theirs.size(); ++k) stops.push_back({ways_b[k], false, theirs[k]});
    std::sort(stops.begin(), stops.end(), [](const Stop& s, const Stop& t) {
      return s.share != t.share ? s.share < t.share : s.of_a > t.of_a;
    });
    // Both sides get the same list of places; `at` names each side's last vertex on it.
    std::uint32_t at_a = tiles_[a].vertices[a_from].vertex;
    std::uint32_t at_b = tiles_[b].vertices[b_from].vertex;
    Vec3d last = place_[a][a_from];
    const Vec3d end = place_[a][a_to];
    std::vector<Vec3d> missing_a, missing_b;
    const auto flush_a = [&](std::uint32_t next) {
      if (!missing_a.empty()) plan_.tiles[a].insert[{at_a, next}] = missing_a;
      missing_a.clear();
      at_a = next;
    };
    const auto flush_b = [&](std::uint32_t next) {
      // Their edge runs the other way.
      std::reverse(missing_b.begin(), missing_b.end());
      if (!missing_b.empty()) plan_.tiles[b].insert[{next, at_b}] = missing_b;
      missing_b.clear();
      at_b = next;
    };
    const std::uint32_t end_a = tiles_[a].vertices[a_to].vertex;
    const std::uint32_t end_b = tiles_[b].vertices[b_to].vertex;
    for (const Stop& s : stops) {
      const std::uint32_t t = s.of_a ? a : b;
      const std::uint32_t v = tiles_[t].vertices[s.index].vertex;
      const Vec3d p = on_lattice(place_[t][s.index]);
      settled_[t][s.index] = true;
      place_[t][s.index] = p;
      const std::uint32_t here = s.of_a ? at_a : at_b;
      const bool last_is_mine = s.of_a ? missing_a.empty() : missing_b.empty();
      if (last_is_mine && norm(p - last) <= options_.collapse_m) {
        plan_.tiles[t].collapse[v] = here;
        place_[t][s.index] = tiles_[t].vertices[s.index].position;
        ++plan_.collapsed;
        continue;
      }
      if (norm(p - end) <= options_.collapse_m) {
        plan_.tiles[t].collapse[v] = s.of_a ? end_a : end_b;
        place_[t][s.index] = tiles_[t].vertices[s.index].position;
        ++plan_.collapsed;
        continue;
      }
      (s.of_a ? missing_b : missing_a).push_back(p);
      ++plan_.inserted;
      s.of_a ? flush_a(v) : flush_b(v);
      last = p;
    }
    flush_a(end_a);
    flush_b(end_b);
  }

  const std::vector<TileBorder>& tiles_;
  const Options& options_;
  Plan plan_;
  std::vector<std::vector<bool>> settled_;
  std::vector<std::vector<Vec3d>> place_;
  std::vector<Box2d> boxes_;
  std::vector<std::unique_ptr<BorderTree>> trees_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> loose_pairs_;
};

}  // namespace

Plan resolve(const std::vector<TileBorder>& tiles, const Options& options) {
  return Resolution(tiles, options).run();
}

}  // namespace cornice::stitch
